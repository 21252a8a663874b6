"""How much to measure."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Options:
    """Campaigns in each cell, shots in each campaign, processes at once; the largest too."""

    campaigns: int
    shots: int
    processes: int
    large: bool = False
