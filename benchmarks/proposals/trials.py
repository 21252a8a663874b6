"""What a section shall measure, what a campaign brought, and a rate beside what is asked of it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class Asked:
    """What a section shall measure: campaigns of each kind, from which seed on.

    Attributes
    ----------
    d
        Strength of what is hidden.
    of
        Only kinds whose name holds this.
    own
        Whether d of a product is of what its arguments by themselves do not do.
    """

    campaigns: int
    d: float
    of: str
    first_seed: int
    own: bool = False


@dataclass(frozen=True, slots=True)
class Trial:
    """One campaign: what it hid, what was said, and how long that took."""

    hidden: str
    seed: int
    treatment: str
    proposals: tuple[tuple[str, str, str], ...]
    alike: tuple[tuple[str, str], ...]
    effects: tuple[str, ...]
    before: float
    after: float
    floor: float
    seconds: float


def print_share(text: str, asked: float, hits: Iterable[bool], *, at_least: bool = True) -> None:
    """Print a rate with its error beside what is asked of it."""
    seen = list(hits)
    value = sum(seen) / max(len(seen), 1)
    moved = (sum(seen) + 2) / (len(seen) + 4)
    error = float(np.sqrt(moved * (1 - moved) / (len(seen) + 4)))
    kept = value >= asked if at_least else value <= asked
    sign = ">=" if at_least else "<="
    print(
        f"{text:<66} {sign} {asked:<5.2g} {value:7.4f} +- {error:.4f} of {len(seen):<4d} "
        f"{'kept' if kept else 'MISSED'}",
        flush=True,
    )
