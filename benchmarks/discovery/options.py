"""How much to measure."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Options:
    """Campaigns in each cell, shots in each campaign, processes at once; the largest too.

    Attributes
    ----------
    slow_px
        Slow error of poses that are as exact as filmed ones, px; None: fresh errors alone.
    by_place
        Whether what all flights share of these errors changes with the place in the field.
    """

    campaigns: int
    shots: int
    processes: int
    large: bool = False
    slow_px: float | None = None
    by_place: bool = False
