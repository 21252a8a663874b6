import numpy as np
import pytest
from drawings import BACKGROUND, SETTINGS, SURFACE, draw, edges_of, grey
from found import At, discs_at
from one_frame import fit_outline
from scipy.ndimage import gaussian_filter

from analysis.arrays import Floats
from analysis.errors import ShotRefusedError
from analysis.imaging.edge.frame import EdgeSettings, find_edges
from analysis.imaging.film_discs import FilmDiscs
from analysis.imaging.radii import filter_bias, shared_radii, view_radii
from analysis.imaging.views import View

LEFT, RIGHT = (48.3, 34.6), (47.1, 86.2)


def fitted(frames: np.ndarray, radius: float, settings: EdgeSettings) -> FilmDiscs:
    found: list[dict[int, At]] = [{}, {}]
    for k, frame in enumerate(frames):
        points = find_edges(frame, settings, 4.0).points
        for own, place in zip(found, (LEFT, RIGHT), strict=True):
            outline = fit_outline(points, (*place, radius), (), 3.0)
            assert outline is not None
            circle = outline.circle
            own[k] = At(circle.row, circle.column, circle.radius, outline.coverage)
    return discs_at(len(frames), {View.FRONT: found[0]}, {View.FRONT: found[1]})


@pytest.mark.parametrize("sigma", [1.2, 2.0])
@pytest.mark.parametrize("radius", [10.0, 14.0, 18.0])
def test_the_filter_enlarges_a_flat_disc_by_half_its_variance_over_the_radius(
    sigma: float, radius: float
) -> None:
    settings = EdgeSettings(sigma)
    picture = draw([(*LEFT, radius), (*RIGHT, radius)])
    frames = np.stack([grey(picture, 1.0, seed) for seed in range(4)])
    discs = fitted(frames, radius, settings)
    bias = filter_bias(frames, discs, settings, 1.0).radius
    assert bias[View.FRONT] == pytest.approx(sigma**2 / (2 * radius), abs=0.02)
    # What is left is the lens's share of the same kind, 0.8^2 / (2 R).
    measured = np.mean(view_radii(discs)[View.FRONT])
    assert measured - bias[View.FRONT] == pytest.approx(radius + 0.32 / radius, abs=0.03)


def shaded(radius: float, slope: float) -> Floats:
    """Return a picture of two discs that are brighter toward the right, blurred as others are."""
    fine = 4
    rows, columns = draw([(*LEFT, radius)]).shape
    y, x = (np.indices((rows * fine, columns * fine)) + 0.5) / fine - 0.5
    picture = np.full(y.shape, float(BACKGROUND))
    for row, column in (LEFT, RIGHT):
        inside = np.hypot(y - row, x - column) < radius
        light = SURFACE * (1.0 + slope * (x - column) / radius)
        picture[inside] = light[inside]
    seen = gaussian_filter(picture, 0.8 * fine)
    return np.asarray(seen.reshape(rows, fine, columns, fine).mean(axis=(1, 3)))


@pytest.mark.parametrize("slope", [0.3, -0.3])
def test_what_shading_shifts_a_disc_by_is_seen_by_the_second_filter(slope: float) -> None:
    frames = np.stack([grey(shaded(18.0, slope), 1.0, seed) for seed in range(8)])
    discs = fitted(frames, 18.0, SETTINGS)
    shifts = discs.circles[:, 0, :, :2].mean(axis=1) - np.array([LEFT, RIGHT])
    bias = filter_bias(frames, discs, SETTINGS, 1.0, 8)
    assert (np.abs(shifts[:, 1]) > 0.02).all()
    left = shifts - bias.place[:, 0]
    assert (np.abs(left[:, 1]) < 0.5 * np.abs(shifts[:, 1])).all()
    assert (np.abs(left[:, 0]) < 0.02).all()


def of_sizes(a: list[tuple[float, float]], b: list[tuple[float, float]]) -> FilmDiscs:
    """Return discs of given radius and coverage, of sphere a and of sphere b."""
    first, second = (
        {View.FRONT: {k: At(radius=r, coverage=share) for k, (r, share) in enumerate(own)}}
        for own in (a, b)
    )
    return discs_at(max(len(a), len(b), 1), first, second)


def test_the_radius_is_the_median_of_well_seen_outlines() -> None:
    a = [(19.9, 1.0), (20.1, 0.8), (20.3, 0.7), (25.0, 0.5), (15.0, 0.4)]
    assert view_radii(of_sizes(a, [(21.0, 0.9)])) == {View.FRONT: (pytest.approx(20.1), 21.0)}


def test_a_sphere_that_is_never_well_seen_is_refused_by_name_and_view() -> None:
    with pytest.raises(ShotRefusedError, match=r"outlines: sphere b .* 60% .* front view"):
        view_radii(of_sizes([(20.0, 1.0)], [(20.0, 0.5), (20.0, 0.55)]))


def test_the_best_seen_outlines_speak_for_both_spheres() -> None:
    discs = of_sizes([(19.9, 0.75), (20.1, 0.7), (18.0, 0.45)], [(23.0, 0.45), (22.0, 0.4)])
    ours = shared_radii(discs, (0.02, 0.024))[View.FRONT]
    assert ours == (pytest.approx(20.0), pytest.approx(24.0))


def test_where_no_outline_is_good_the_best_of_them_gives_the_radius() -> None:
    discs = of_sizes([(19.5, 0.5), (18.0, 0.41)], [(19.7, 0.48), (17.0, 0.4)])
    assert shared_radii(discs, (0.02, 0.02))[View.FRONT] == (pytest.approx(19.6),) * 2


def test_a_view_without_any_outline_is_refused_by_name() -> None:
    with pytest.raises(ShotRefusedError, match="outlines: no sphere is found in the front view"):
        shared_radii(of_sizes([], []), (0.02, 0.02))


def test_without_a_frame_that_shows_all_outlines_no_bias_is_known() -> None:
    radius = 14.0
    frames = grey(draw([(*LEFT, radius), (*RIGHT, radius)]))[None]
    discs = fitted(frames, radius, SETTINGS)
    discs.coverage[1, 0, 0] = -1.0
    bias = filter_bias(frames, discs, SETTINGS, 1.0)
    assert bias.radius == {View.FRONT: 0.0}
    assert not bias.place.any()


def test_the_drawing_has_the_contrast_that_these_tests_assume() -> None:
    strength = edges_of(draw([(*LEFT, 14.0)])).points.strength
    steepest = (SURFACE - BACKGROUND) / np.sqrt(2 * np.pi * (SETTINGS.sigma_px**2 + 0.8**2))
    assert np.median(strength) == pytest.approx(steepest, rel=0.05)
