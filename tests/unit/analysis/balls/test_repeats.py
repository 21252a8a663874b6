"""Rhythms in which films repeat pictures, told by how a ball moves from frame to frame."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.balls.seen.repeats import BroughtToRateError, Rhythm, refuse_brought_to_rate
from tests.unit.cli.falling_ball import RATE, bouncing

Place = np.ndarray[tuple[int, int], np.dtype[np.float64]]


def seen(which: list[int]) -> list[Place]:
    """Return where a ball is seen to a tenth of a pixel, in frames that show some pictures."""
    rows, rng = bouncing(), np.random.default_rng(5)
    return [np.array([[rows[k] + 0.05 * rng.standard_normal(), 60.0, 1.0]]) for k in which]


def rhythm_of(which: list[int]) -> Rhythm | None:
    try:
        refuse_brought_to_rate(seen(which), np.arange(len(which)) / RATE)
    except BroughtToRateError as brought:
        return brought.rhythm
    return None


@pytest.mark.parametrize(("pictures", "frames"), [(1, 2), (1, 3), (2, 5), (4, 5), (5, 6), (9, 10)])
@pytest.mark.parametrize("phase", [0, 3])
def test_the_rhythm_of_a_film_brought_to_another_rate_is_found(
    pictures: int, frames: int, phase: int
) -> None:
    which = [(k + phase) * pictures // frames for k in range(99 * frames // pictures)]
    found = rhythm_of([min(99, k) for k in which])
    assert found is not None
    assert (found.pictures, found.frames) == (pictures, frames)
    again = np.diff(which, prepend=-1) == 0
    assert np.array_equal(found.repeats(len(which)), again)


def test_a_film_in_which_other_pictures_stand_for_lost_ones_keeps_its_times() -> None:
    assert rhythm_of([k - (k % 9 == 0) for k in range(1, 99)]) is None


@pytest.mark.parametrize("twice", [[], [20, 33, 41, 70, 82]])
def test_films_that_repeat_no_picture_or_some_without_a_rhythm_have_none(twice: list[int]) -> None:
    assert rhythm_of(sorted([*range(99), *twice])) is None
