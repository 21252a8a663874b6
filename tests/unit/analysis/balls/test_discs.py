"""Discs in pictures drawn by area, and in pictures that a camera took."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.balls.discs.candidates import candidates
from analysis.balls.discs.finding import find_balls
from analysis.balls.discs.gradient import gradient
from analysis.balls.discs.judging import false_alarms, log_binomial_tail

REAL = Path(__file__).parents[5] / "shared" / "data" / "real-images"


def drawn(discs: list[tuple[float, float, float, float]], noise: float = 3.0) -> NDArray[np.uint8]:
    fine = 4
    picture = np.full((160 * fine, 240 * fine), 90.0)
    row, column = (np.mgrid[: 160 * fine, : 240 * fine] + 0.5) / fine - 0.5
    for y, x, radius, grey in discs:
        picture[np.hypot(row - y, column - x) < radius] = grey
    small = picture.reshape(160, fine, 240, fine).mean(axis=(1, 3))
    rng = np.random.default_rng(0)
    blurred = cv2.GaussianBlur(small, (0, 0), 0.8) + noise * rng.standard_normal(small.shape)
    return np.clip(blurred, 0, 255).astype(np.uint8)


def test_bright_dark_and_overlapping_discs_are_found_where_they_were_drawn() -> None:
    discs = [(50.3, 60.7, 22.0, 200.0), (95.0, 180.2, 30.0, 20.0), (70.0, 95.0, 18.0, 150.0)]
    found = sorted(find_balls(drawn(discs), (10.0, 40.0)), key=lambda disc: disc.column)
    assert len(found) == 3
    for disc, (row, column, radius, _) in zip(
        found, sorted(discs, key=lambda d: d[1]), strict=True
    ):
        assert (disc.row, disc.column) == pytest.approx((row, column), abs=0.3)
        assert disc.radius == pytest.approx(radius, abs=0.3)


def test_the_border_of_what_is_lit_on_a_ball_is_no_ball_of_its_own() -> None:
    ball, lit = (80.0, 120.0, 36.0, 150.0), (72.0, 118.0, 24.0, 235.0)
    (found,) = find_balls(drawn([ball, lit]), (10.0, 45.0))
    assert (found.row, found.column, found.radius) == pytest.approx(ball[:3], abs=0.3)


def test_a_disc_cut_by_the_picture_s_edge_is_found() -> None:
    (found,) = find_balls(drawn([(80.0, 5.0, 25.0, 200.0)]), (15.0, 35.0))
    assert (found.row, found.column) == pytest.approx((80.0, 5.0), abs=0.5)


def test_colour_alone_shows_a_disc() -> None:
    grey = drawn([(80.0, 120.0, 25.0, 200.0)], noise=0.0).astype(np.float64)
    # Green falls as red rises: the sum of the channels is the same everywhere.
    picture = np.stack([np.full_like(grey, 90.0), 290.0 - grey, grey], axis=2).astype(np.uint8)
    (found,) = find_balls(picture, (15.0, 35.0))
    assert (found.row, found.column) == pytest.approx((80.0, 120.0), abs=0.3)


def test_a_dark_ball_on_a_dark_cloth_is_found_beside_bright_clutter() -> None:
    rng = np.random.default_rng(2)
    shown = np.full((240, 400), 20.0, np.float32)
    for _ in range(60):
        (row, column), (rows, columns) = rng.integers(0, (220, 140)), rng.integers(6, 30, 2)
        shown[row : row + rows, column : min(160, column + columns)] = rng.uniform(40, 255)
    cv2.circle(shown, (290, 120), 24, (23.0,), -1, cv2.LINE_AA)
    noisy = cv2.GaussianBlur(shown, (0, 0), 0.8) + rng.normal(0, 0.4, shown.shape)
    (found,) = find_balls(noisy, (10.0, 40.0))
    assert (found.row, found.column, found.radius) == pytest.approx((120.0, 290.0, 24.0), abs=0.5)


def test_what_is_as_its_ground_within_a_ring_is_no_ball() -> None:
    shown = np.full((200, 300), 230.0, np.float32)
    cv2.circle(shown, (150, 100), 20, (20.0,), 7, cv2.LINE_AA)
    noisy = cv2.GaussianBlur(shown, (0, 0), 0.8)
    noisy += np.random.default_rng(1).normal(0, 1, shown.shape).astype(np.float32)
    assert find_balls(noisy, (6.0, 60.0)) == []


def test_a_ball_is_found_where_its_shadow_and_it_have_a_circle_in_common() -> None:
    shown = np.full((200, 300), 120.0, np.float32)
    cv2.circle(shown, (146, 108), 24, (60.0,), -1, cv2.LINE_AA)
    cv2.circle(shown, (150, 100), 22, (200.0,), -1, cv2.LINE_AA)
    noisy = cv2.GaussianBlur(shown, (0, 0), 0.8)
    noisy += np.random.default_rng(1).normal(0, 1, shown.shape).astype(np.float32)
    (found,) = find_balls(noisy, (6.0, 60.0))
    assert (found.row, found.column, found.radius) == pytest.approx((100.0, 150.0, 22.0), abs=0.7)


def test_candidates_of_a_busy_corner_leave_room_for_those_elsewhere() -> None:
    rng = np.random.default_rng(4)
    turns = np.arange(0.0, 2.0 * np.pi, 0.08)
    ball = 12.0 * np.stack([np.sin(turns), np.cos(turns)], axis=1)
    busy = [ball * rng.uniform(0.9, 1.1) / 1.5 + rng.uniform(20.0, 140.0, 2) for _ in range(900)]
    faint = ball[::3] + np.array([260.0, 420.0])
    points = np.concatenate([*busy, faint])
    ways = np.concatenate([ball] * 900 + [ball[::3]])
    ways = -ways / np.linalg.norm(ways, axis=1)[:, None]
    rows = np.argsort(points[:, 0])
    edges = np.concatenate([points, ways], axis=1)[rows].astype(np.float32)
    places = candidates(edges, (320, 480), (8.0, 16.0))
    assert np.hypot(*(places[:, 1:3] - np.array([260.0, 420.0])).T).min() < 2.0


@pytest.mark.parametrize("seed", range(5))
def test_noise_shows_no_discs(seed: int) -> None:
    noise = np.random.default_rng(seed).normal(120.0, 20.0, (160, 240))
    assert find_balls(np.clip(noise, 0, 255).astype(np.uint8), (10.0, 40.0)) == []


def test_light_and_shade_that_fall_off_towards_a_centre_have_no_rim() -> None:
    rng = np.random.default_rng(6)
    blotches = cv2.GaussianBlur(rng.standard_normal((240, 320)).astype(np.float32), (0, 0), 10)
    shown = 120 + 40 * blotches / blotches.std() + rng.normal(0, 1, blotches.shape)
    assert find_balls(shown, (6.0, 80.0)) == []


def test_a_ball_that_is_smeared_to_an_oval_is_one() -> None:
    shown = np.full((240, 320), 8.0, np.float32)
    cv2.ellipse(shown, (160, 120), (26, 21), 0, 0, 360, (240.0,), -1, cv2.LINE_AA)
    noise = np.random.default_rng(1).normal(0, 1, shown.shape)
    assert len(find_balls(cv2.GaussianBlur(shown, (0, 0), 1.0) + noise, (6.0, 80.0))) == 1


def test_stripes_and_corners_show_no_discs() -> None:
    row, column = np.mgrid[:160, :240]
    stripes = np.where((row // 20 + column // 30) % 2 == 0, 60, 180).astype(np.uint8)
    assert find_balls(stripes, (10.0, 40.0)) == []


def test_deep_pictures_are_taken_as_they_are() -> None:
    deep = drawn([(80.0, 120.0, 25.0, 200.0)]).astype(np.uint16) * 200
    assert len(find_balls(deep, (15.0, 35.0))) == 1


def test_where_a_surer_disc_has_its_rim_the_one_behind_it_need_not_show_its_own() -> None:
    shown = np.atleast_3d(drawn([(80.0, 120.0, 30.0, 200.0)])).astype(np.float32)
    found = gradient(shown)
    circle = np.array([80.0, 120.0, 30.0])
    taken, gone = found.field.copy(), found.field.copy()
    taken[0, :, :112], gone[0, :, :112] = -1.0, 0.0
    clear, hidden = (
        false_alarms(field, found.threshold, circle.copy(), 6.0) for field in (taken, gone)
    )
    # Of all angles those are left whose cosine is above -8/30.
    share = 1.0 - np.arccos(8.0 / 30.0) / np.pi
    assert clear[2] == pytest.approx(share, abs=0.03)
    assert hidden[2] == 1.0
    assert clear[1] == pytest.approx(hidden[1])
    assert clear[0] < hidden[0] - 5.0


def test_the_tail_of_the_binomial_is_that_of_its_sum() -> None:
    exact = sum(
        np.prod([(20 - i) / (i + 1) for i in range(k)]) * 0.25**k * 0.75 ** (20 - k)
        for k in range(12, 21)
    )
    assert log_binomial_tail(20, 12, 0.25) == pytest.approx(np.log10(exact), abs=1e-6)


@pytest.mark.shared_data
@pytest.mark.skipif(not REAL.exists(), reason="real pictures lie beside a development checkout")
@pytest.mark.parametrize(
    ("name", "radii", "count"),
    [("scikit-image/coins.png", (15.0, 35.0), 24)]
    + [(f"trackpy-brightfield/bf_{k:04d}.png", (6.0, 20.0), 5) for k in (0, 10, 20, 30)],
)
def test_all_discs_of_real_pictures_are_found_and_none_besides(
    name: str, radii: tuple[float, float], count: int
) -> None:
    picture = cv2.imread(str(REAL / name), cv2.IMREAD_GRAYSCALE)
    assert len(find_balls(np.asarray(picture), radii)) == count
