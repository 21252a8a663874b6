import math
from functools import cache

import numpy as np
from drawings import SETTINGS
from found import At, discs_at
from one_frame import fit_outline
from rendered import OPTICS, RADIUS_PX, picture, setup_of

from analysis.imaging.edge.frame import FrameEdges, find_edges
from analysis.imaging.film_discs import FilmDiscs
from analysis.imaging.film_following import FilmCurves
from analysis.imaging.radii import Appearance, refine_outlines
from analysis.imaging.views import View, view_geometries
from simulators.world import WorldDescription
from simulators.world.optics import front_view

(FRONT, _) = VIEWS = view_geometries(setup_of(WorldDescription(optics=OPTICS)).camera)
MARKER_ANGLE = 0.16
A, B = np.array([0.0012, -0.0203, 0.0018]), np.array([0.0008, 0.0211, -0.0009])
ANGLES = (0.3, 2.2, 3.9)
LIMB = np.array([[math.cos(a), math.sin(a), 0.1] for a in ANGLES])
LIMB /= np.linalg.norm(LIMB, axis=1, keepdims=True)


@cache
def edges() -> list[FrameEdges]:
    """Return the edges of four frames, found once: not by each process that loads this."""
    return [find_edges(picture(A, B, LIMB, seed=k), SETTINGS, 4.0) for k in range(4)]


def true_place(centre: np.ndarray) -> tuple[float, float]:
    return front_view(OPTICS).centre_px(centre, OPTICS.scale_px_per_m)


def film_curves() -> FilmCurves:
    """Return the edges of all frames one after the other."""
    points = [own.points for own in edges()]
    names = "row", "column", "normal_row", "normal_column", "strength"
    filled = np.array([np.concatenate([getattr(p, name) for p in points]) for name in names])
    ends = np.cumsum([len(p) for p in points])
    labels = np.concatenate([own.labels for own in edges()])
    return filled, labels, np.stack([ends - [len(p) for p in points], ends], axis=1)


def plain_outline(frame: int, centre: np.ndarray) -> At:
    outline = fit_outline(edges()[frame].points, (*true_place(centre), RADIUS_PX), (), 3.0)
    assert outline is not None
    circle = outline.circle
    return At(circle.row, circle.column, circle.radius, outline.coverage)


def plain() -> FilmDiscs:
    a, b = ({View.FRONT: {k: plain_outline(k, c) for k in range(4)}} for c in (A, B))
    return discs_at(4, a, b)


def refined(radius: float, *, known: bool = True) -> FilmDiscs:
    nothing = np.full((4, 0, 3), np.nan)
    standing = np.tile(LIMB, (4, 1, 1)) if known else nothing
    knowledge = Appearance({View.FRONT: (radius, radius)}, (standing, nothing), MARKER_ANGLE)
    return refine_outlines(film_curves(), (FRONT,), plain(), knowledge, SETTINGS.sigma_px)


def offset(discs: FilmDiscs, sphere: int) -> np.ndarray:
    """Return by how much the centre stands off the truth, mean over the frames, pixels."""
    return np.mean(discs.circles[sphere, 0, :, :2] - true_place((A, B)[sphere]), axis=0)


def nearest_point_to_a_marker(discs: FilmDiscs) -> float:
    """Return the least angle at the centre between a limb point and a marker, radians."""
    row, column = true_place(A)
    outlines = discs.tracks()[0][View.FRONT].outlines.values()
    points = np.concatenate([o.points for o in outlines])
    angle = np.arctan2(points[:, 1] - column, points[:, 0] - row)
    return float(min(np.abs((angle - a + math.pi) % (2 * math.pi) - math.pi).min() for a in ANGLES))


def test_stretches_of_the_limb_under_a_marker_are_left_out() -> None:
    with_them, without = refined(RADIUS_PX, known=False), refined(RADIUS_PX)
    margin = MARKER_ANGLE + 1.5 * SETTINGS.sigma_px / RADIUS_PX
    assert nearest_point_to_a_marker(with_them) < 0.75 * margin
    assert nearest_point_to_a_marker(without) > 0.9 * margin


def test_a_marked_sphere_is_found_as_well_as_a_plain_one() -> None:
    # Shading alone moves the plain sphere b by a few hundredths of a pixel, and a as much.
    found = offset(refined(float(plain().circles[1, 0, :, 2].mean())), 0)
    assert np.hypot(*(found - offset(plain(), 1))) < 0.05
    assert np.hypot(*found) < 0.1


def test_the_known_radius_is_held() -> None:
    assert refined(RADIUS_PX + 0.2).circles[0, 0, :, 2].tolist() == [RADIUS_PX + 0.2] * 4


def test_a_sphere_without_known_markers_keeps_its_whole_limb() -> None:
    again = refined(RADIUS_PX)
    assert again.coverage[1, 0].tolist() == [1.0] * 4
    moved = again.circles[1, 0, :, :2] - plain().circles[1, 0, :, :2]
    assert np.hypot(*moved.T).max() < 0.1


def test_frames_without_an_outline_stay_without() -> None:
    discs = plain()
    discs.coverage[0, 0, 1] = -1.0
    nothing = np.full((4, 0, 3), np.nan)
    knowledge = Appearance({View.FRONT: (RADIUS_PX,) * 2}, (nothing, nothing), MARKER_ANGLE)
    again = refine_outlines(film_curves(), (FRONT,), discs, knowledge, SETTINGS.sigma_px)
    assert again.found[:, 0].tolist() == [[True, False, True, True], [True] * 4]
    assert sorted(again.tracks()[0][View.FRONT].outlines) == [0, 2, 3]
