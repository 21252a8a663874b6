"""A sweep at one moment, as an unchangeable snapshot."""

from __future__ import annotations

from dataclasses import dataclass

from rigctl.store import StepRecord, SweepRecord
from rigctl.sweeps.coefficient import Mean
from rigctl.sweeps.orders import Wish


@dataclass(frozen=True, slots=True)
class SweepStatus:
    """Progress of a sweep, its present step and its orders.

    Attributes
    ----------
    record
        The sweep with the counts of its steps.
    asked
        Order that takes effect before the next fire; None without one.
    step
        The step under way; None between steps and while the sweep does not run.
    left_s
        Estimated time to its end, s; None while unknown.
    mean
        The coefficient that ends the sweep, as known so far; None without one.
    warnings
        What is foreseen of its steps, known where it was just started.
    """

    record: SweepRecord
    asked: Wish | None = None
    step: StepRecord | None = None
    left_s: float | None = None
    mean: Mean | None = None
    warnings: tuple[str, ...] = ()
