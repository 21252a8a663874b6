import math
from dataclasses import replace

import numpy as np
import pytest
from drawings import SETTINGS, Place, draw, edges_of
from hypothesis import given, settings
from hypothesis import strategies as st
from one_frame import fit_outline

from analysis.imaging.outlines import Outline

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


@pytest.mark.parametrize("gap", [0.0, 2.0])
def test_discs_that_touch_or_nearly_do_not_pull_each_other(gap: float) -> None:
    apart = 2 * RADIUS + gap
    first, second = (40.0, 40.0, RADIUS), (52.0, 40.0 + math.sqrt(apart**2 - 12**2), RADIUS)
    for place, other in ((first, second), (second, first)):
        outline = outline_of(place, (other,))
        assert miss(outline, place) < 0.05
        assert outline.coverage < 1.0
        from_other = np.hypot(outline.points[:, 0] - other[0], outline.points[:, 1] - other[1])
        assert from_other.min() > RADIUS + KEEP_OFF


def test_an_edge_across_the_limb_is_not_the_limb_s() -> None:
    points = edges_of(draw([(48.0, 60.0, RADIUS)])).points
    crossing = points.column > 60.0
    turned = replace(
        points,
        normal_row=np.where(crossing, -points.normal_column, points.normal_row),
        normal_column=np.where(crossing, points.normal_row, points.normal_column),
    )
    outline = fit_outline(turned, (48.0, 60.0, RADIUS), (), KEEP_OFF)
    assert outline is not None
    assert outline.points[:, 1].max() < 60.5
    assert outline.coverage == pytest.approx(0.5, abs=0.06)


def test_edge_points_that_are_blocked_or_too_few_give_no_outline() -> None:
    points = edges_of(draw([(48.0, 60.0, RADIUS)])).points
    blocked = np.ones(len(points), dtype=np.bool_)
    start = (48.0, 60.0, RADIUS)
    assert fit_outline(points, start, (), KEEP_OFF, blocked=blocked) is None
    assert fit_outline(points, (20.0, 100.0, RADIUS), (), KEEP_OFF) is None
    assert fit_outline(points, start, (), KEEP_OFF) is not None
