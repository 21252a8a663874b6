"""Sweeps and their steps as unchangeable snapshots."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from rigctl.settings import ShotSettings
from rigctl.store.sweep_states import StepState, SweepState


@dataclass(frozen=True, slots=True)
class NewSweep:
    """What is known of a sweep when it is accepted.

    Attributes
    ----------
    steps
        Settings of each step in the order of firing.
    form
        JSON text of the request, from which the steps were made.
    rules
        JSON text of how it is run (`rigctl.sweeps.plan.Rules`).
    actor, accepted_at
        Who requested it, and when (UTC; it dates the sweep's name).
    """

    steps: tuple[ShotSettings, ...]
    form: str
    rules: str
    campaign: str | None
    actor: str
    accepted_at: datetime


@dataclass(frozen=True, slots=True)
class SweepRecord:
    """One sweep as the catalogue has it.

    Attributes
    ----------
    id, number
        `YYYYMMDD-sNNNN` (UTC date and number); the number rises through restarts.
    reason
        Reason of its state, in one sentence.
    form, rules
        JSON texts: the request, and how it is run.
    counts
        How many of its steps stand in each state; states without a step are left out.
    ended_at
        When it was completed or aborted, UTC.
    """

    id: str
    number: int
    state: SweepState
    reason: str
    form: str
    rules: str
    campaign: str | None
    actor: str
    accepted_at: datetime
    ended_at: datetime | None
    counts: dict[StepState, int]

    @property
    def steps(self) -> int:
        """How many steps it has, whatever became of them."""
        return sum(self.counts.values())


@dataclass(frozen=True, slots=True)
class StepRecord:
    """One step: the settings of one shot, and what became of it.

    Attributes
    ----------
    number
        Its place in the order of firing, from 1.
    attempt
        How often it was taken; more than once only where nothing had flown before.
    key
        Idempotency key of its present attempt; None before the first.
    shot
        Its shot; None while there is none.
    failure
        Why it came to nothing, in one sentence.
    """

    number: int
    settings: ShotSettings
    state: StepState
    attempt: int
    key: str | None
    shot: str | None
    taken_at: datetime | None
    ended_at: datetime | None
    failure: str | None
