import math

import numpy as np
import pytest
from drawings import SETTINGS, Place, draw, edges_of
from hypothesis import given, settings
from hypothesis import strategies as st

from analysis.imaging.outlines import Outline, fit_outline

RADIUS, BLUR = 18.0, 0.8
KEEP_OFF = 2.5 * SETTINGS.sigma_px
TOO_LARGE = (SETTINGS.sigma_px**2 + BLUR**2) / (2 * RADIUS)
"""How far outside a blurred flat disc the zero of the Laplacian of Gaussian lies."""


def outline_of(
    place: Place,
    others: tuple[Place, ...] = (),
    markers: tuple[Place, ...] = (),
    *,
    hold_radius: bool = False,
) -> Outline:
    frame = draw([place, *others], markers=markers, blur_px=BLUR)
    start = (place[0] + 1.5, place[1] - 1.5, RADIUS + (TOO_LARGE if hold_radius else 0.5))
    outline = fit_outline(edges_of(frame).points, start, others, KEEP_OFF, hold_radius=hold_radius)
    assert outline is not None
    return outline


def miss(outline: Outline, place: Place) -> float:
    return math.hypot(outline.circle.row - place[0], outline.circle.column - place[1])


@settings(max_examples=25, deadline=None)
@given(row=st.floats(40, 56), column=st.floats(40, 80))
def test_a_free_disc_is_found_to_a_fiftieth_of_a_pixel(row: float, column: float) -> None:
    place = (row, column, RADIUS)
    outline = outline_of(place)
    assert miss(outline, place) < 0.02
    assert outline.coverage == 1.0
    assert outline.circle.radius == pytest.approx(RADIUS + TOO_LARGE, abs=0.015)
    rho = np.hypot(outline.points[:, 0] - row, outline.points[:, 1] - column)
    assert np.abs(rho - RADIUS - TOO_LARGE).max() < 0.6


@pytest.mark.parametrize("angle", [0.0, 1.0, 2.5, 4.0])
def test_a_marker_that_cuts_the_limb_moves_the_centre_by_less_than_a_tenth(angle: float) -> None:
    place = (48.2, 60.4, RADIUS)
    limb = (48.2 + 17 * math.cos(angle), 60.4 + 17 * math.sin(angle), 4.0)
    outline = outline_of(place, markers=(limb,))
    assert miss(outline, place) < 0.1
    assert outline.coverage < 1.0


@pytest.mark.parametrize("column", [2.0, 118.0])
def test_a_disc_half_out_of_view_is_found_by_the_half_that_shows(column: float) -> None:
    place = (48.0, column, RADIUS)
    outline = outline_of(place, hold_radius=True)
    assert miss(outline, place) < 0.05
    assert 0.4 < outline.coverage < 0.65


def test_touching_discs_do_not_pull_each_other() -> None:
    first, second = (40.0, 40.0, RADIUS), (52.0, 40.0 + math.sqrt(36**2 - 12**2), RADIUS)
    for place, other in ((first, second), (second, first)):
        outline = outline_of(place, (other,))
        assert miss(outline, place) < 0.05
        assert outline.coverage < 1.0


def test_edge_points_that_are_blocked_or_too_few_give_no_outline() -> None:
    points = edges_of(draw([(48.0, 60.0, RADIUS)])).points
    blocked = np.ones(len(points), dtype=np.bool_)
    start = (48.0, 60.0, RADIUS)
    assert fit_outline(points, start, (), KEEP_OFF, blocked=blocked) is None
    assert fit_outline(points, (20.0, 100.0, RADIUS), (), KEEP_OFF) is None
    assert fit_outline(points, start, (), KEEP_OFF) is not None
