import math

import numpy as np
import pytest
from drawings import SETTINGS
from one_frame import find_markers, fit_outline
from rendered import OPTICS, RADIUS_PX, picture, setup_of

from analysis.imaging.edge.frame import FrameEdges, find_edges, gradient_threshold
from analysis.imaging.marker.markers import Markers, SeenDisc
from analysis.imaging.outlines import Outline
from analysis.imaging.views import View, ViewGeometry, view_geometries
from simulators.world import WorldDescription
from simulators.world.optics import front_view, top_view

VIEWS = {v.view: v for v in view_geometries(setup_of(WorldDescription(optics=OPTICS)).camera)}
CENTRE = np.array([0.0012, -0.0203, 0.0018])
THRESHOLD = gradient_threshold(OPTICS.noise_grey, SETTINGS.sigma_px)


def place_in(view: ViewGeometry) -> tuple[float, float, float]:
    camera = front_view(OPTICS) if view.view is View.FRONT else top_view(OPTICS)
    return (*camera.centre_px(CENTRE, OPTICS.scale_px_per_m), RADIUS_PX)


def seen(
    edges: FrameEdges, view: ViewGeometry, others: tuple[tuple[float, float, float], ...] = ()
) -> tuple[Markers, Outline]:
    outline = fit_outline(edges.points, place_in(view), others, 3.0)
    assert outline is not None
    disc = SeenDisc(outline, outline.circle.radius, view)
    return find_markers(edges, [disc], others)[0], outline


def marker_at(view: ViewGeometry, tilt_deg: float, around_deg: float) -> np.ndarray:
    tilt, around = math.radians(tilt_deg), math.radians(around_deg)
    rho = math.sin(tilt)
    row, column = np.array([rho * math.cos(around)]), np.array([rho * math.sin(around)])
    return view.direction(row, column)[0]


@pytest.mark.parametrize("view", list(View))
@pytest.mark.parametrize("tilt_deg", [0.0, 15.0, 30.0, 40.0, 50.0])
def test_a_marker_is_found_where_it_stands_to_a_fiftieth_of_a_radian(
    view: View, tilt_deg: float
) -> None:
    for around_deg in (20.0, 110.0, 200.0, 310.0):
        true = marker_at(VIEWS[view], tilt_deg, around_deg)
        edges = find_edges(picture(CENTRE, None, true[None]), SETTINGS, THRESHOLD)
        markers, _ = seen(edges, VIEWS[view])
        assert len(markers) == 1
        angle = math.acos(min(1.0, float(markers.directions[0] @ true)))
        assert angle < 0.02, (tilt_deg, around_deg)
        assert markers.facing[0] == pytest.approx(math.cos(math.radians(tilt_deg)), abs=0.02)


def test_a_marker_is_as_large_as_it_was_painted() -> None:
    true = marker_at(VIEWS[View.FRONT], 20.0, 45.0)
    edges = find_edges(picture(CENTRE, None, true[None]), SETTINGS, THRESHOLD)
    markers, outline = seen(edges, VIEWS[View.FRONT])
    assert len(markers) == 1
    assert markers.ellipses[0, 2] / outline.circle.radius == pytest.approx(math.sin(0.16), rel=0.15)


def test_each_of_several_markers_is_found_once() -> None:
    places = [(0.0, 0.0), (38.0, 0.0), (38.0, 120.0), (38.0, 240.0)]
    true = np.array([marker_at(VIEWS[View.FRONT], *place) for place in places])
    edges = find_edges(picture(CENTRE, None, true), SETTINGS, THRESHOLD)
    markers, _ = seen(edges, VIEWS[View.FRONT])
    nearest = (true @ markers.directions.T).argmax(axis=0).tolist()
    assert sorted(nearest) == [0, 1, 2, 3]


def test_a_marker_at_the_limb_is_not_measured() -> None:
    true = marker_at(VIEWS[View.FRONT], 80.0, 30.0)
    edges = find_edges(picture(CENTRE, None, true[None]), SETTINGS, THRESHOLD)
    assert len(seen(edges, VIEWS[View.FRONT])[0]) == 0


def test_a_plain_sphere_has_no_marker() -> None:
    edges = find_edges(picture(CENTRE, None, np.empty((0, 3))), SETTINGS, THRESHOLD)
    for view in VIEWS.values():
        assert len(seen(edges, view)[0]) == 0


def test_a_marker_that_reaches_into_another_disc_may_be_either_spheres_and_is_left_out() -> None:
    true = marker_at(VIEWS[View.FRONT], 40.0, 90.0)
    edges = find_edges(picture(CENTRE, None, true[None]), SETTINGS, THRESHOLD)
    row, column, radius = place_in(VIEWS[View.FRONT])
    covering = (row, column + 1.5 * radius, radius)
    clear = (row, column + 2.2 * radius, radius)
    assert len(seen(edges, VIEWS[View.FRONT], (clear,))[0]) == 1
    outline = seen(edges, VIEWS[View.FRONT])[1]
    disc = SeenDisc(outline, radius, VIEWS[View.FRONT])
    assert len(find_markers(edges, [disc], [covering])[0]) == 0
