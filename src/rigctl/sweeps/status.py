"""A sweep at one moment, as an unchangeable snapshot."""

from __future__ import annotations

from dataclasses import dataclass

from rigctl.store import StepRecord, SweepRecord
from rigctl.sweeps.coefficient import Mean
from rigctl.sweeps.orders import Wish


@dataclass(frozen=True, slots=True)
class SweepStatus:
    """What a sweep has done, does and is asked to do.

    Attributes
    ----------
    record
        The sweep with the counts of its steps.
    asked
        What takes effect before the next fire; None when nothing is asked.
    step
        The step under way; None between steps and while the sweep does not run.
    left_s
        Estimated time to its end, s; None while nobody can say.
    mean
        The coefficient that ends the sweep, as known so far; None without one.
    """

    record: SweepRecord
    asked: Wish | None = None
    step: StepRecord | None = None
    left_s: float | None = None
    mean: Mean | None = None
