import math

import numpy as np
from drawings import SETTINGS
from rendered import OPTICS, RADIUS_PX, picture, setup_of

from analysis.imaging.frame import find_edges
from analysis.imaging.outlines import Outline, fit_outline
from analysis.imaging.refinement import Knowledge, refine_outlines
from analysis.imaging.tracks import Spheres, Track
from analysis.imaging.views import View, view_geometries
from simulators.world import WorldDescription
from simulators.world.optics import front_view

(FRONT, _) = VIEWS = view_geometries(setup_of(WorldDescription(optics=OPTICS)).camera)
MARKER_ANGLE = 0.16
A, B = np.array([0.0012, -0.0203, 0.0018]), np.array([0.0008, 0.0211, -0.0009])
ANGLES = (0.3, 2.2, 3.9)
LIMB = np.array([[math.cos(a), math.sin(a), 0.1] for a in ANGLES])
LIMB /= np.linalg.norm(LIMB, axis=1, keepdims=True)
EDGES = [find_edges(picture(A, B, LIMB, seed=k), SETTINGS, 4.0) for k in range(4)]


def true_place(centre: np.ndarray) -> tuple[float, float]:
    return front_view(OPTICS).centre_px(centre, OPTICS.scale_px_per_m)


def plain_outline(frame: int, centre: np.ndarray) -> Outline:
    outline = fit_outline(EDGES[frame].points, (*true_place(centre), RADIUS_PX), (), 3.0)
    assert outline is not None
    return outline


def tracks() -> Spheres:
    a, b = (Track(View.FRONT, {k: plain_outline(k, c) for k in range(4)}) for c in (A, B))
    return {View.FRONT: a}, {View.FRONT: b}


def refined(radius: float, *, known: bool = True) -> Spheres:
    standing = dict.fromkeys(range(4), LIMB) if known else {}
    knowledge = Knowledge({View.FRONT: (radius, radius)}, (standing, {}), MARKER_ANGLE)
    return refine_outlines(EDGES, (FRONT,), tracks(), knowledge, SETTINGS.sigma_px)


def offset(spheres: Spheres, sphere: int) -> np.ndarray:
    """Return by how much the centre stands off the truth, mean over the frames, pixels."""
    row, column = true_place((A, B)[sphere])
    circles = [outline.circle for outline in spheres[sphere][View.FRONT].outlines.values()]
    return np.mean([(c.row - row, c.column - column) for c in circles], axis=0)


def nearest_point_to_a_marker(spheres: Spheres) -> float:
    """Return the least angle at the centre between a limb point and a marker, radians."""
    row, column = true_place(A)
    points = np.concatenate([o.points for o in spheres[0][View.FRONT].outlines.values()])
    angle = np.arctan2(points[:, 1] - column, points[:, 0] - row)
    return float(min(np.abs((angle - a + math.pi) % (2 * math.pi) - math.pi).min() for a in ANGLES))


def test_stretches_of_the_limb_under_a_marker_are_left_out() -> None:
    with_them, without = refined(RADIUS_PX, known=False), refined(RADIUS_PX)
    margin = MARKER_ANGLE + 1.5 * SETTINGS.sigma_px / RADIUS_PX
    assert nearest_point_to_a_marker(with_them) < 0.75 * margin
    assert nearest_point_to_a_marker(without) > 0.9 * margin


def test_a_marked_sphere_is_found_as_well_as_a_plain_one() -> None:
    plain = [outline.circle.radius for outline in tracks()[1][View.FRONT].outlines.values()]
    # Shading alone moves the plain sphere b by a few hundredths of a pixel, and a as much.
    found = offset(refined(float(np.mean(plain))), 0)
    assert np.hypot(*(found - offset(tracks(), 1))) < 0.05
    assert np.hypot(*found) < 0.1


def test_the_known_radius_is_held() -> None:
    circles = [o.circle for o in refined(RADIUS_PX + 0.2)[0][View.FRONT].outlines.values()]
    assert [circle.radius for circle in circles] == [RADIUS_PX + 0.2] * 4


def test_a_sphere_without_known_markers_keeps_its_whole_limb() -> None:
    plain, again = tracks()[1][View.FRONT], refined(RADIUS_PX)[1][View.FRONT]
    assert sorted(again.outlines) == [0, 1, 2, 3]
    for k, outline in again.outlines.items():
        assert outline.coverage == 1.0
        before, now = plain.outlines[k].circle, outline.circle
        assert math.hypot(now.row - before.row, now.column - before.column) < 0.1
