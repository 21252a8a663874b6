"""Commissioning over REST: strict orders, complete answers."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Self

from pydantic import BaseModel, Field

from rigctl.commissioning.acts import Found
from rigctl.commissioning.gate import Standing
from rigctl.commissioning.step import Act, Part
from rigctl.config.model import StrictModel
from rigctl.plain_text import Line
from rigctl.service.forms import View

MOST_PEOPLE = 16
People = Annotated[list[Line], Field(min_length=1, max_length=MOST_PEOPLE)]
"""Who has looked."""


class AnswerOrder(StrictModel):
    """Whether a step was as it must be; a no needs a note of what was seen instead."""

    seen: bool
    people: People
    note: Line | None = None


class RewiredOrder(StrictModel):
    """A part whose wiring, board or firmware was worked on: its steps are asked for again."""

    part: Annotated[Part, Field(strict=False)]
    people: People
    note: Line


class FoundView(View):
    """What the daemon saw of its act: `holds` when it was what the step needs."""

    holds: bool
    text: str


class StepView(View):
    """One step. `missing` says why it is asked for, and is empty once it was seen."""

    name: str
    part: Part
    title: str
    do: str
    see: str
    act: Act | None
    missing: str
    answer: str | None
    answered_at: datetime | None
    people: list[str]
    note: str | None
    found: FoundView | None = Field(description="what the daemon saw since the last answer")

    @classmethod
    def of(cls, standing: Standing, found: Found | None) -> Self:
        """Return a step as REST shows it."""
        said = standing.answer
        return cls.showing(
            standing.step,
            missing=standing.missing,
            answer=None if said is None else said.answer,
            answered_at=None if said is None else datetime.fromisoformat(said.at),
            people=[] if said is None else list(said.people),
            note=None if said is None else said.note or None,
            found=None if found is None else FoundView.showing(found),
        )


class CommissioningView(BaseModel):
    """All steps in order. A real rig fires nothing while `complete` is false."""

    complete: bool
    needed: bool = Field(description="whether this rig must be commissioned: a real one must")
    next: str | None = Field(description="the first step that is asked for")
    steps: list[StepView]
