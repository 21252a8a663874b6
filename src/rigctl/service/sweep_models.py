"""Sweeps as they go in and out over REST."""

from __future__ import annotations

import json
from datetime import datetime
from typing import Any, Self

from pydantic import BaseModel, Field

from rigctl.service.forms import Query, View
from rigctl.settings import ShotSettings
from rigctl.store import StepRecord, StepState, SweepRecord, SweepState
from rigctl.sweeps.coefficient import Mean
from rigctl.sweeps.orders import Wish
from rigctl.sweeps.status import SweepStatus


class SweepQuery(Query):
    """Which sweeps to list; `before` is the id of the last sweep of the page before."""

    state: SweepState | None = None
    limit: int = Field(default=100, ge=1, le=500)
    before: str | None = Field(default=None, pattern=r"^\d{8}-s\d{4,12}$")


class StepView(View):
    """One step of a sweep. Times are UTC; `shot` is null while there is none."""

    step: int = Field(description="place in the order of firing, from 1")
    state: StepState
    settings: ShotSettings
    attempt: int = Field(description="how often it was begun; nothing flew before the last time")
    shot: str | None
    taken_at: datetime | None
    ended_at: datetime | None
    failure: str | None

    @classmethod
    def of(cls, step: StepRecord) -> Self:
        """Return a step as REST shows it."""
        return cls.showing(step, step=step.number)


class MeanView(View):
    """A coefficient's mean over the measured shots of a sweep; no `sigma` before the third."""

    coefficient: str
    value: float
    sigma: float | None
    sigma_own: float | None
    sigma_common: float
    shots: int

    @classmethod
    def of(cls, mean: Mean) -> Self:
        """Return a mean as REST shows it."""
        return cls.showing(mean, sigma_own=mean.own, sigma_common=mean.common)


class SweepView(View):
    """One sweep. Times are UTC; what is not known is null."""

    sweep: str
    state: SweepState
    reason: str = Field(description="why it stands there, and what to do next")
    asked: Wish | None = Field(description="what takes effect before the next fire")
    campaign: str | None
    actor: str
    accepted_at: datetime
    ended_at: datetime | None
    steps: int = Field(description="how many steps it has")
    counts: dict[StepState, int] = Field(description="how many of them stand in each state")
    current: StepView | None = Field(description="the step under way")
    left_s: float | None = Field(description="estimated time to its end, s")
    mean: MeanView | None = Field(description="the coefficient that ends it, as known so far")
    warnings: list[str] = Field(description="of its steps, in the answer to its start")

    @classmethod
    def of(cls, status: SweepStatus) -> Self:
        """Return a snapshot as REST shows it."""
        record = status.record
        return cls.showing(
            record,
            sweep=record.id,
            asked=status.asked,
            counts={state: record.counts.get(state, 0) for state in StepState},
            current=None if status.step is None else StepView.of(status.step),
            left_s=status.left_s,
            mean=None if status.mean is None else MeanView.of(status.mean),
            warnings=list(status.warnings),
        )


class SweepTable(BaseModel):
    """The request in the form of a sweep file, and the steps in the order of firing."""

    form: dict[str, Any]
    table: list[StepView]

    @classmethod
    def of(cls, record: SweepRecord, steps: list[StepRecord]) -> Self:
        """Return the steps of a sweep as REST shows them."""
        return cls(form=json.loads(record.form), table=[StepView.of(step) for step in steps])


class SweepList(BaseModel):
    """Sweeps, latest first; `next` is the `before` of the page that follows, null at the end."""

    sweeps: list[SweepView]
    next: str | None
