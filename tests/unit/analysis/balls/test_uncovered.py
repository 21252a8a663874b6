"""A ball that lies in its place for half of a film hides what stands still there."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from analysis.balls.films.film import HeldFilm
from analysis.balls.flight.known import Ball
from analysis.balls.looking import Looked
from analysis.balls.searching import search
from tests.unit.cli.falling_ball import DIAMETER_MM, RATE, bouncing, picture

RESTS_FROM = 185
"""Frame; before it the ball bounces twice, the second time to 10 px above its plate."""


def test_a_ball_that_rests_in_a_film_is_seen_in_place_in_its_low_flights() -> None:
    frames = 420
    rows = np.array(bouncing(frames, 0.5))
    film = HeldFilm(Path("drawn"), np.array([picture(row) for row in rows]))
    found = search(Looked(film), np.arange(frames) / RATE, Ball(1e-3 * DIAMETER_MM))
    second, third = found.chain.times_s[:2] * RATE
    low = [arc for arc in found.chain.arcs if second < arc.frames.mean() < third + 40]
    assert len(found.chain.arcs) >= 3
    for arc in low:
        assert np.abs(arc.places[:, 0] - rows[arc.frames]).max() < 1.5
    late = found.unexplained[found.unexplained[:, 0] > RESTS_FROM]
    assert np.abs(late[:, 1] - rows[late[:, 0].astype(int)]).max(initial=0.0) < 1.5
