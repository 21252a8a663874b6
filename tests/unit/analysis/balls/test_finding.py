from pathlib import Path

import cv2
import drawings
import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.balls.discs.finding import find_balls

DISCS = [(30.4, 28.7, 14.0), (60.2, 60.9, 22.0), (28.3, 93.5, 18.0), (75.6, 105.1, 12.5)]


def test_discs_of_several_sizes_are_found_once_each_with_their_radii() -> None:
    found = find_balls(drawings.grey(drawings.draw(DISCS), noise=2.0), (10.0, 25.0))
    assert len(found) == len(DISCS)
    for row, column, radius in DISCS:
        nearest = min(found, key=lambda d: np.hypot(d.row - row, d.column - column))
        assert (nearest.row, nearest.column) == pytest.approx((row, column), abs=0.1)
        # The filter makes a disc too large by about sigma^2 / (2 R).
        assert nearest.radius == pytest.approx(radius, abs=0.15)
        assert nearest.rim > 0.85
        assert 0.0 < nearest.row_sigma < 0.08


def test_dark_discs_on_a_bright_ground_are_found_as_well() -> None:
    found = find_balls(drawings.grey(200.0 - drawings.draw(DISCS), noise=2.0), (10.0, 25.0))
    assert len(found) == len(DISCS)


def test_a_disc_outside_the_range_of_diameters_is_left_out() -> None:
    found = find_balls(drawings.grey(drawings.draw(DISCS), noise=1.0), (16.0, 25.0))
    assert sorted(round(d.radius) for d in found) == [18, 22]


def test_an_even_or_noisy_picture_holds_no_disc() -> None:
    flat = np.full((96, 120), 90.0)
    assert find_balls(drawings.grey(flat), (10.0, 25.0)) == []
    assert find_balls(drawings.grey(flat, noise=5.0), (10.0, 25.0)) == []


REAL = Path(__file__).resolve().parents[5] / "shared" / "data" / "real-images"
BEADS = [(24, 255), (113, 399), (127, 296), (290, 78), (364, 280)]
COINS = [
    *((55, 44), (57, 100), (50, 155), (51, 215), (52, 276), (43, 335)),
    *((125, 45), (126, 103), (127, 154), (125, 206), (119, 270), (125, 336)),
    *((197, 43), (195, 101), (198, 154), (193, 212), (193, 273), (187, 347)),
    *((260, 46), (266, 114), (261, 172), (264, 244), (264, 302), (267, 358)),
]
"""Places (row, column) read off by eye."""


@pytest.mark.shared_data
@pytest.mark.skipif(not REAL.is_dir(), reason="the real images are not beside this checkout")
@pytest.mark.parametrize(
    ("name", "diameters", "places", "reach"),
    [
        ("trackpy-brightfield/bf_0000.png", (12.0, 30.0), BEADS, 3.0),
        ("scikit-image/coins.png", (30.0, 70.0), COINS, 8.0),
    ],
)
def test_every_bead_and_every_coin_of_a_real_picture_is_found_and_nothing_else(
    name: str, diameters: tuple[float, float], places: list[tuple[int, int]], reach: float
) -> None:
    picture = cv2.imread(str(REAL / name), cv2.IMREAD_GRAYSCALE)
    assert picture is not None
    found = find_balls(picture, (diameters[0] / 2, diameters[1] / 2))
    assert len(found) == len(places)
    for row, column in places:
        near = [d for d in found if np.hypot(d.row - row, d.column - column) < reach]
        assert len(near) == 1, (row, column)


def test_a_sphere_hidden_to_two_fifths_is_found_where_its_rim_is_sharp() -> None:
    picture = drawings.grey(drawings.draw([(60.3, 64.8, 24.0)]), noise=2.0)
    picture[65:, 30:100] = 90
    found = find_balls(picture, (8.0, 40.0))
    assert len(found) == 1
    assert (found[0].row, found[0].column) == pytest.approx((60.3, 64.8), abs=0.3)


def test_gloss_on_a_sphere_is_no_sphere() -> None:
    picture = drawings.grey(drawings.draw([(60.3, 64.8, 40.0)]), noise=2.0)
    rows, columns = np.mgrid[: picture.shape[0], : picture.shape[1]]
    picture[np.hypot(rows - 48, columns - 54) < 9] = 255
    found = find_balls(picture, (6.0, 50.0))
    assert [round(disc.radius) for disc in found] == [40]


def test_stated_errors_of_a_centre_hold_its_distance_from_the_drawn_one() -> None:
    rng = np.random.default_rng(5)
    pulls = []
    for _ in range(12):
        row, column = rng.uniform(40, 60), rng.uniform(50, 70)
        picture = drawings.grey(drawings.draw([(row, column, 22.0)]), noise=4.0)
        (disc,) = find_balls(picture, (15.0, 30.0))
        pulls += [(disc.row - row) / disc.row_sigma, (disc.column - column) / disc.column_sigma]
    assert np.sqrt(np.mean(np.square(pulls))) < 1.5
    assert np.abs(pulls).max() < 4


@pytest.mark.parametrize(
    ("grey", "aside", "print_px", "hidden"), [(130.0, 9.0, 26.0, 140), (120.0, 3.0, 18.0, 104)]
)
def test_a_number_in_a_sharp_ring_on_a_ball_is_no_ball(
    grey: float, aside: float, print_px: float, hidden: int
) -> None:
    # The ring is surer than the rim, which lies before spots or partly behind something.
    rng = np.random.default_rng(0)
    picture = np.asarray(cv2.GaussianBlur(rng.normal(150.0, 60.0, (140, 160)), (0, 0), 2.0))
    rows, columns = np.mgrid[:140, :160]
    picture = np.where(np.hypot(rows - 70, columns - 80) < 50, grey, picture)
    picture = np.where(np.hypot(rows - 70, columns - 80 - aside) < print_px, 250.0, picture)
    picture[hidden:] = 110.0
    blurred = np.asarray(cv2.GaussianBlur(picture, (0, 0), 0.8))
    (disc,) = find_balls(drawings.grey(blurred, noise=2.0), (6.0, 60.0))
    assert (disc.row, disc.column, disc.radius) == pytest.approx((70, 80, 50), abs=0.5)


@pytest.mark.parametrize("seed", [20, 27])
def test_a_faint_ball_behind_something_is_found_by_the_sharp_half_of_its_rim(seed: int) -> None:
    rng = np.random.default_rng(seed)
    spots = np.asarray(cv2.GaussianBlur(rng.normal(0.0, 1.0, (140, 160)), (0, 0), 3.0))
    ball = drawings.coverage((60.3, 64.8, 22.0), (140, 160))
    picture = 110.0 + 15.0 * spots / spots.std() + 42.0 * cv2.GaussianBlur(ball, (0, 0), 0.5)
    picture[66:] = 110.0
    (disc,) = find_balls(drawings.grey(np.asarray(picture), noise=2.0), (8.0, 40.0))
    assert (disc.row, disc.column) == pytest.approx((60.3, 64.8), abs=1.5)
    assert disc.radius == pytest.approx(22.0, abs=1.0)


@pytest.mark.parametrize(("width", "seed"), [(6.0, 0), (6.0, 21), (12.0, 5), (12.0, 16)])
def test_soft_blotches_of_a_ground_are_no_discs(width: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    blotches = np.asarray(cv2.GaussianBlur(rng.normal(0.0, 1.0, (240, 320)), (0, 0), width))
    noise = rng.normal(0.0, 1.5, blotches.shape)
    assert not find_balls(
        drawings.grey(110.0 + 25.0 * blotches / blotches.std() + noise), (8.0, 60.0)
    )


@pytest.mark.parametrize("seed", [0, 8])
def test_a_ball_as_bright_as_its_shaded_ground_is_found_by_its_hue(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shade = np.asarray(cv2.GaussianBlur(rng.normal(0.0, 1.0, (140, 160)), (0, 0), 3.0))
    ground = 100.0 + 30.0 * shade / shade.std()
    ball = cv2.GaussianBlur(drawings.coverage((60.3, 64.8, 22.0), (140, 160)), (0, 0), 0.6)
    channels = [ground + change * ball for change in (24.0, -24.0, 6.0)]
    picture = np.stack(channels, axis=2) + rng.normal(0.0, 1.5, (140, 160, 3))
    (disc,) = find_balls(np.clip(np.rint(picture), 0, 255).astype(np.uint8), (8.0, 40.0))
    assert (disc.row, disc.column, disc.radius) == pytest.approx((60.3, 64.8, 22.0), abs=0.3)


@pytest.mark.parametrize("seed", [0, 3, 11])
def test_faint_exposures_are_found_by_the_radius_and_step_of_the_others(seed: int) -> None:
    places = [(48.3, 40.2), (40.6, 78.9), (44.1, 117.4), (58.8, 155.7), (84.2, 194.1)]
    rng = np.random.default_rng(seed)
    grain = np.asarray(cv2.GaussianBlur(rng.normal(0.0, 1.0, (140, 240)), (0, 0), 3.0))
    picture = 100.0 + 16.0 * grain / grain.std()
    for k, place in enumerate(places):
        cover = cv2.GaussianBlur(drawings.coverage((*place, 20.0), (140, 240)), (0, 0), 0.6)
        picture = picture + (36.0 if k else 70.0) * np.asarray(cover)
    found = find_balls(drawings.grey(picture, noise=2.0), (8.0, 40.0))
    # Three are sure by themselves.
    assert len(found) == len(places)
    for disc in found:
        assert min(np.hypot(disc.row - row, disc.column - column) for row, column in places) < 1.5
        assert disc.radius == pytest.approx(20.0, abs=1.0)
        assert disc.rim > 0.2
    assert [disc.log_alarms for disc in found] == sorted(disc.log_alarms for disc in found)


@pytest.mark.parametrize("seed", [1, 3])
def test_blotches_as_large_as_a_ball_are_not_taken_for_more_of_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    blotches = np.asarray(cv2.GaussianBlur(rng.normal(0.0, 1.0, (240, 320)), (0, 0), 10.0))
    ball = cv2.GaussianBlur(drawings.coverage((120.3, 160.8, 18.0), (240, 320)), (0, 0), 0.6)
    picture = 110.0 + 25.0 * blotches / blotches.std() + 70.0 * np.asarray(ball)
    (disc,) = find_balls(drawings.grey(picture, noise=1.5), (8.0, 60.0))
    assert (disc.row, disc.column, disc.radius) == pytest.approx((120.3, 160.8, 18.0), abs=0.5)


def figure(place: tuple[float, float], radius: float, sides: int, rounded: float) -> np.ndarray:
    """Return the cover of a figure of some mean radius, its corners rounded by a share of it."""
    fine = 4
    row, column = ((np.indices((150 * fine, 230 * fine)) + 0.5) / fine - 0.5) - np.reshape(
        place, (2, 1, 1)
    )
    # A core with sharp corners, as far around as the rounding goes.
    turn = np.arange(sides) * 2 * np.pi / sides + 0.3
    inner = radius * (1 - rounded)
    corners = inner * np.stack([np.sin(turn), np.cos(turn)], axis=1) / np.cos(np.pi / sides)
    away = np.full(row.shape, -np.inf)
    nearest = np.full(row.shape, np.inf)
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        way = b - a
        share = ((row - a[0]) * way[0] + (column - a[1]) * way[1]) / (way @ way)
        share = np.clip(share, 0.0, 1.0)
        nearest = np.minimum(
            nearest, np.hypot(row - a[0] - share * way[0], column - a[1] - share * way[1])
        )
        middle = (a + b) / 2
        outward = middle / np.hypot(*middle)
        away = np.maximum(away, row * outward[0] + column * outward[1] - middle @ outward)
    inside = (away < 0) | (nearest < radius * rounded)
    return np.asarray(inside.reshape(150, fine, 230, fine).mean(axis=(1, 3)))


@pytest.mark.parametrize(("sides", "rounded"), [(4, 0.5), (4, 0.7), (6, 0.0), (6, 0.3), (8, 0.0)])
def test_rounded_squares_and_polygons_beside_a_disc_of_their_size_are_no_discs(
    sides: int, rounded: float
) -> None:
    picture = np.full((150, 230), 90.0) + 80.0 * drawings.coverage((40.3, 45.8, 19.0), (150, 230))
    for place in [(40.0, 120.4), (42.6, 190.0), (108.2, 50.1), (110.0, 118.0), (107.7, 188.3)]:
        picture += 80.0 * figure(place, 18.0, sides, rounded)
    blurred = np.asarray(cv2.GaussianBlur(picture, (0, 0), 0.7))
    (disc,) = find_balls(drawings.grey(blurred, noise=2.0), (8.0, 60.0))
    assert (disc.row, disc.column, disc.radius) == pytest.approx((40.3, 45.8, 19.0), abs=0.3)


def outlines(seed: int, radius: float, wave: float) -> NDArray[np.uint8]:
    """Return a heap of figures whose outlines go two and three times off a circle and back."""
    rng = np.random.default_rng(seed)
    fine, turn = 4, np.linspace(0.0, 2.0 * np.pi, 400)
    shown = np.full((240 * fine, 320 * fine), 90.0, np.float32)
    for _ in range(60):
        middle, starts = rng.uniform((0, 0), (240, 320)), rng.uniform(0.0, 2.0 * np.pi, 2)
        away = rng.uniform(0.6, 1.4) * radius
        away = away * (
            1 + wave * sum(np.cos(n * turn + a) for n, a in zip((2, 3), starts, strict=True))
        )
        line = np.stack([middle[1] + away * np.cos(turn), middle[0] + away * np.sin(turn)], axis=1)
        cv2.fillPoly(shown, [np.rint(fine * line).astype(np.int32)], float(rng.uniform(40, 200)))
    small = cv2.GaussianBlur(
        cv2.resize(shown, (320, 240), interpolation=cv2.INTER_AREA), (0, 0), 0.9
    )
    return np.clip(small + 2.0 * rng.standard_normal(small.shape), 0, 255).astype(np.uint8)


def test_of_outlines_that_leave_a_circle_by_a_tenth_of_its_radius_few_are_discs() -> None:
    found = [len(find_balls(outlines(seed, 28.0, 0.1), (6.0, 80.0))) for seed in range(5)]
    # By a limit on each thing that is seen, 50 of the 300 were.
    assert sum(found) <= 40
