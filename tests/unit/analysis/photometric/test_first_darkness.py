"""How dark markers are, read off pictures that were drawn by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.imaging.marker.markers import FilmMarkers, Markers
from analysis.photometric.follow.start import first_darkness

ROWS, COLUMNS, RADIUS = 60, 80, 4.0
PLACES = [(20.0, 20.0), (20.0, 58.0), (40.0, 38.0)]


def picture(darkness: float, grey: float) -> np.ndarray:
    down, across = np.mgrid[:ROWS, :COLUMNS]
    light = grey + 0.2 * across
    for row, column in PLACES:
        light = np.where(np.hypot(down - row, across - column) <= RADIUS, 1 - darkness, 1) * light
    return np.rint(light).astype(np.uint8)


def seen(places: list[tuple[float, float]], facing: float) -> FilmMarkers:
    ellipses = np.array([[*place, RADIUS, RADIUS, 0.0, 0.0] for place in places]).reshape(-1, 6)
    count = len(places)
    every = Markers(
        ellipses, np.tile([0.0, 0.0, 1.0], (count, 1)), np.full(count, facing), np.ones(count, bool)
    )
    return FilmMarkers(np.array([0]), np.array([count]), every)


@given(st.floats(0.05, 0.95), st.floats(80.0, 200.0))
def test_the_share_of_the_light_that_markers_lack_is_read_off(darkness: float, grey: float) -> None:
    frames = picture(darkness, grey)[None]
    found = first_darkness(frames, (seen(PLACES[:2], 0.9), seen(PLACES[2:], 0.9)))
    assert found == pytest.approx(darkness, abs=0.02)


def test_markers_at_the_limb_say_nothing() -> None:
    assert first_darkness(picture(0.5, 100.0)[None], (seen(PLACES, 0.5),)) is None
    assert first_darkness(picture(0.5, 100.0)[None], (seen([], 0.9),)) is None
