"""Spheres in frames that hold no pose of them."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.photometric.follow.film import whereabouts

TIMES_S = np.arange(40) * 1e-3
GRAVITY = 9.8


def thrown():
    """A sphere's free flight, m, shape (frames, 3)."""
    fall = 0.5 * GRAVITY * TIMES_S**2
    return np.stack([-0.02 - 0.3 * TIMES_S + fall, 1.5 * TIMES_S, 0.1 * TIMES_S], axis=1)


def test_a_track_goes_on_in_free_flight_on_both_sides_and_through_its_gaps():
    path, placed = thrown(), np.zeros(40, dtype=np.bool_)
    placed[8:30], placed[15] = True, False
    known = np.where(placed[:, None], path, 9.0)
    there, doubt = whereabouts(known, placed, TIMES_S, GRAVITY)
    assert there == pytest.approx(path, abs=5e-6)
    assert (doubt[placed] == 0).all()
    assert (np.diff(doubt[29:]) > 0).all()
    assert doubt[0] == pytest.approx(0.04 * TIMES_S[8])


@pytest.mark.parametrize("frames", [[], [7]])
def test_fewer_than_two_poses_tell_nothing(frames):
    placed = np.isin(np.arange(40), frames)
    there, doubt = whereabouts(thrown(), placed, TIMES_S, GRAVITY)
    assert there == pytest.approx(thrown())
    assert (doubt == 0).all()
