"""What a sweep is to do: its steps in the order of firing, and the rules by which it goes on."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Literal

from analysis.errors import counted
from rigctl.config import Configuration, Limits
from rigctl.errors import SettingsError
from rigctl.rig.bounds import misses, require_within
from rigctl.settings import ShotSettings
from rigctl.sweeps.form import Sweep

Coefficient = Literal["e", "beta"]


@dataclass(frozen=True, slots=True)
class Until:
    """End the sweep once a coefficient is known well enough.

    Attributes
    ----------
    coefficient
        A coefficient of each shot's result.
    sigma
        Standard error of its mean over the sweep's shots that is to be reached, by their own
        errors: no number of shots reduces what all of them share.
    """

    coefficient: Coefficient
    sigma: float


@dataclass(frozen=True, slots=True)
class Rules:
    """How a sweep is run.

    Attributes
    ----------
    settle_s
        Further wait between the settings being reached and the fire, s.
    pause_s
        Rest after each shot, beyond the rig's own cool-down, s.
    most_failed
        So many steps in a row that come to nothing pause the sweep.
    until
        When it may end early; None: after its last step.
    adaptive
        Whether the step with the most expected information comes next, not the first.
    """

    settle_s: float = 0.0
    pause_s: float = 0.0
    most_failed: int = 3
    until: Until | None = None
    adaptive: bool = False

    def to_json(self) -> str:
        """Return the rules as the catalogue keeps them."""
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, text: str) -> Rules:
        """Return the rules that `to_json` wrote."""
        fields = json.loads(text)
        until = fields.pop("until")
        return cls(**fields, until=None if until is None else Until(**until))


@dataclass(frozen=True, slots=True)
class Plan:
    """A sweep before it is accepted; `form` is the JSON text of the request."""

    steps: tuple[ShotSettings, ...]
    rules: Rules
    form: str
    campaign: str | None = None


def plan_of(form: Sweep) -> Plan:
    """Return the plan of a sweep file or request, with its shots in the order of firing."""
    until = form.until
    rules = Rules(
        settle_s=form.settle_s,
        pause_s=form.pause_s,
        most_failed=form.most_failed,
        until=None if until is None else Until(until.coefficient, until.sigma),
        adaptive=until is not None and until.adaptive,
    )
    return Plan(tuple(form.steps()), rules, form.model_dump_json(), form.campaign)


def warnings_of(plan: Plan, configuration: Configuration) -> tuple[str, ...]:
    """Warn of steps whose spheres cannot meet in level flight, with their number; empty without."""
    unmet = [found for step in plan.steps for found in misses(step, configuration)]
    if not unmet:
        return ()
    return (
        f"{len(unmet)} of {counted(len(plan.steps), 'shot')} will miss; of the first, {unmet[0]}",
    )


def require_possible(plan: Plan, limits: Limits) -> None:
    """Check a whole plan against the rig's limits, before anything moves.

    Raises
    ------
    SettingsError
        It has no step, a step lies outside the limits, or it would settle for longer than an arm
        token lives.
    """
    if not plan.steps:
        raise SettingsError("the sweep has no step", todo="give it settings to fire")
    if plan.rules.settle_s >= limits.arm_lifetime_s:
        raise SettingsError(
            "the arm token would expire while the sweep lets the rig settle",
            part="settle_s",
            value=f"{plan.rules.settle_s:g} s",
            limit=f"less than {limits.arm_lifetime_s:g} s",
            todo="settle for a shorter time",
        )
    for number, settings in enumerate(plan.steps, start=1):
        try:
            require_within(settings, limits)
        except SettingsError as error:
            raise SettingsError(
                error.what,
                part=f"step {number}, {error.part}",
                value=error.value,
                limit=error.limit,
                todo=error.todo,
            ) from error
