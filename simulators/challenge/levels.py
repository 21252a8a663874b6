"""Levels of a game: what may be hidden in each, from one plain effect to what nobody knows."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from pathlib import Path

import numpy as np

from simulators.challenge.effects import HIDDEN
from simulators.challenge.label import Amplitudes, draw_label
from simulators.challenge.making import write_challenge

_LABEL = 0
_MOST_DRAWN = 10_000


def _known(label: Amplitudes) -> bool:
    return all(HIDDEN[name].known for name in label)


def _plain(label: Amplitudes) -> bool:
    hidden = [HIDDEN[name] for name in label]
    return len(hidden) == 1 and _known(label) and not any(one.like or one.subtle for one in hidden)


def _one(label: Amplitudes) -> bool:
    return len(label) <= 1 and _known(label)


def _alike(label: Amplitudes) -> bool:
    return len(label) == 1 and _known(label) and any(HIDDEN[name].like for name in label)


def _two(label: Amplitudes) -> bool:
    return len(label) == 2 and _known(label)


def _any(label: Amplitudes) -> bool:
    return len(label) >= 0


LEVELS: tuple[tuple[str, Callable[[Amplitudes], bool]], ...] = (
    ("full", _plain),
    ("full", _one),
    ("full", _two),
    ("full", _alike),
    ("full", _any),
    ("quarter", _any),
)
"""Strength, and what a label of the level may be: one plain effect; one or none; two; one that
others look like; anything, also what no catalogue holds; the same, a quarter as strong."""


def new_level(folder: Path, *, level: int, seed: int | None, shots: int) -> None:
    """Write a challenge of a level, counted from 1; a seed gives the same one again.

    Raises
    ------
    ValueError
        There is no such level, or as `write_challenge`.
    OSError
        The folder cannot be written.
    """
    if not 1 <= level <= len(LEVELS):
        raise ValueError(f"levels are 1 to {len(LEVELS)}, found {level}")
    strength, belongs = LEVELS[level - 1]
    rng = np.random.default_rng(secrets.randbits(63) if seed is None else seed)
    for _ in range(_MOST_DRAWN):
        drawn = int(rng.integers(2**62))
        label = draw_label(np.random.default_rng([drawn, _LABEL]), strength)
        if belongs(label):
            write_challenge(folder, label, drawn, shots)
            return
    raise ValueError(f"nothing of level {level} was drawn in {_MOST_DRAWN} tries")
