import numpy as np
import pytest
from drawings import BACKGROUND, Place, draw, edges_of

from analysis.imaging.discs import (
    PADDING_PX,
    common_radius,
    discs,
    peaks_near,
    vote,
)
from analysis.imaging.edge.frame import FrameEdges
from analysis.imaging.limb import Edges

TWO = [(40.3, 30.7, 18.0), (52.6, 88.2, 18.0)]


def found_in(places: list[Place], radius: float) -> list[tuple[float, float, float]]:
    edges = edges_of(draw(places), noise=1.5)
    peaks = discs(vote(edges.points, radius, edges.shape), 0.2, radius)
    return [(disc.row, disc.column, disc.rim_share) for disc in peaks]


def test_each_disc_is_found_to_a_pixel_with_nearly_its_whole_rim() -> None:
    found = sorted(found_in(TWO, 18.0), key=lambda disc: disc[1])
    assert len(found) == 2
    for (row, column, share), expected in zip(found, TWO, strict=True):
        assert (row, column) == pytest.approx(expected[:2], abs=1.0)
        assert share == pytest.approx(1.0, abs=0.35)


def test_touching_discs_are_two() -> None:
    touching = [(40.0, 40.0, 18.0), (52.0, 73.9, 18.0)]
    found = sorted(found_in(touching, 18.0)[:2], key=lambda disc: disc[1])
    for (row, column, _), expected in zip(found, touching, strict=True):
        assert (row, column) == pytest.approx(expected[:2], abs=1.0)


@pytest.mark.parametrize("centre", [(45.0, 1.0), (-4.0, 60.0), (97.0, 60.0)])
def test_a_disc_half_out_of_view_has_its_centre_beyond_the_frame(
    centre: tuple[float, float],
) -> None:
    row, column, share = found_in([(*centre, 18.0)], 18.0)[0]
    assert (row, column) == pytest.approx(centre, abs=1.5)
    assert share < 0.75


def test_an_empty_frame_has_no_disc() -> None:
    assert found_in([], 18.0) == []


def limbs_of(edges: FrameEdges) -> Edges:
    points = edges.points
    return points.row, points.column, points.normal_row, points.normal_column


def votes_at(votes: np.ndarray, row: float, column: float) -> float:
    """Return the most votes of the pixels about a place."""
    r, c = round(row) + PADDING_PX, round(column) + PADDING_PX
    return float(votes[r - 2 : r + 3, c - 2 : c + 3].max())


def test_the_peak_near_a_prediction_is_its_own_disc() -> None:
    edges = edges_of(draw(TWO))
    votes = vote(edges.points, 18.0, edges.shape)
    expected = np.array([(55.0, 85.0, 18.0), (38.0, 33.0, 18.0)])
    found = peaks_near(limbs_of(edges), expected, 6.0)
    for (row, column, share), true in zip(found, reversed(TWO), strict=True):
        assert (row, column) == pytest.approx(true[:2], abs=1.0)
        assert share == pytest.approx(votes_at(votes, row, column), rel=1e-4)


@pytest.mark.parametrize("place", [(-80.0, 20.0), (20.0, 400.0), (300.0, 20.0)])
def test_a_prediction_out_of_the_image_has_no_peak(place: tuple[float, float]) -> None:
    found = peaks_near(limbs_of(edges_of(draw(TWO))), np.array([(*place, 18.0)]), 6.0)
    assert found[0, 2] == 0.0


@pytest.mark.parametrize("radius", [11.0, 14.5, 18.0])
def test_the_common_radius_of_two_discs_is_known_to_a_pixel(radius: float) -> None:
    places = [(row, column, radius) for row, column, _ in TWO]
    edges = edges_of(draw(places), noise=1.5)
    found = common_radius(edges.points, edges.shape, (6.0, 40.0), {1.0: 2})
    assert found == pytest.approx(radius, abs=1.0)


def test_markers_do_not_outvote_two_discs_that_show_half_of_their_limbs() -> None:
    """The lower half of each disc fades into what lies behind it."""
    places = [(40.0, 30.0, 18.0), (45.0, 85.0, 18.0)]
    spots = [
        (row + 11.0 * np.sin(turn), column + 11.0 * np.cos(turn), 3.5)
        for row, column, _ in places
        for turn in np.arange(0.3, 6.2, 1.2)
    ]
    picture = draw(places, markers=spots)
    fade = np.clip((60.0 - np.arange(len(picture))) / 30.0, 0.0, 1.0)[:, None]
    edges = edges_of(BACKGROUND + (picture - BACKGROUND) * fade, noise=1.5)
    found = common_radius(edges.points, edges.shape, (3.0, 40.0), {1.0: 2})
    assert found == pytest.approx(18.0, abs=1.0)
