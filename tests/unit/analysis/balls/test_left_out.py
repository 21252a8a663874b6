"""Rhythms in which films leave pictures out, told by how a ball moves from frame to frame."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.balls.seen.left_out import ThinnedError, refuse_thinned
from tests.unit.cli.falling_ball import RATE, bouncing

Place = np.ndarray[tuple[int, int], np.dtype[np.float64]]


SLOW = 5
"""Of the pictures of the drawn camera only each so many are taken: forty a second."""


def seen(which: list[int], across_px: float = 0.0) -> list[Place]:
    """Return where a ball is seen to a fifth of a pixel, in frames that show some pictures."""
    rows, rng = bouncing(SLOW * 300)[::SLOW], np.random.default_rng(5)
    noise = 0.2 * rng.standard_normal((len(which), 2))
    return [
        np.array([[rows[k] + off[0], 60.0 + across_px * k + off[1], 1.0]])
        for k, off in zip(which, noise, strict=True)
    ]


def pictures_of(
    which: list[int], across_px: float = 0.0, rounded_s: float = 1e-6
) -> list[int] | None:
    times = np.arange(len(which)) * SLOW / RATE
    try:
        refuse_thinned(seen(which, across_px), np.rint(times / rounded_s) * rounded_s)
    except ThinnedError as thinned:
        return [int(n) for n in thinned.pictures]
    return None


def shown(ratio: float, phase: float, count: int) -> list[int]:
    """Return which pictures a film of fewer frames a second shows."""
    return [int(k * ratio + phase) - int(phase) for k in range(int(count / ratio))]


@pytest.mark.parametrize("ratio", [1.2, 1.25, 1.184, 1.5, 2.5])
@pytest.mark.parametrize("phase", [0.0, 0.7])
def test_pictures_that_are_left_out_in_a_rhythm_are_told(ratio: float, phase: float) -> None:
    which = shown(ratio, phase, 100)
    found = pictures_of(which, 3.0)
    assert found == which


def test_times_that_a_file_rounds_are_those_of_a_rate() -> None:
    which = shown(1.2, 0.0, 100)
    assert pictures_of(which, 3.0, rounded_s=2e-3) == which


def test_a_rhythm_that_slips_once_is_followed() -> None:
    which = shown(1.2, 0.0, 60)
    which += [which[-1] + n for n in (1, 2, 3)] + [which[-1] + 3 + k for k in shown(1.2, 0.9, 60)]
    found = pictures_of(which, 3.0)
    assert found is not None
    assert np.abs(np.subtract(found, which)).max() <= 1


@pytest.mark.parametrize("across_px", [0.0, 3.0])
def test_a_film_of_all_pictures_leaves_none_out(across_px: float) -> None:
    assert pictures_of(list(range(200)), across_px) is None


def test_frames_that_are_lost_here_and_there_keep_no_rhythm() -> None:
    lost = {17, 30, 58, 73}
    assert pictures_of([k for k in range(100) if k not in lost], 3.0) is None


def test_frames_with_times_of_their_own_keep_them() -> None:
    which = shown(1.2, 0.0, 100)
    refuse_thinned(seen(which, 3.0), np.array(which) * SLOW / RATE)
