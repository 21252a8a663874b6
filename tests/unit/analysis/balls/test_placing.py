"""Places, blur and exposure of a ball that is drawn by counting fine pixels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.balls.seen.misfits import falls_to
from analysis.balls.seen.photometry import MAP_SIDE, fit_place
from analysis.balls.seen.placing import Placer
from analysis.balls.seen.windows import Motion, Window
from analysis.balls.settling import observed_of
from analysis.balls.systematics import by_radius

Floats = NDArray[np.float64]

SIZE, RADIUS, FLOOR_ROW = 80, 16.0, 40
FINE = 5
PERIOD_S = 1.0 / 240.0


def ball(
    row: float, column: float, smear: float = 0.0, shadow: float = 0.0, radius: float = RADIUS
) -> Floats:
    """Draw a ball lit from above before a wall and over a floor as bright as its lower half.

    Smeared along the rows; a shadow of that depth lies on the floor below it.
    """
    rows, columns = (np.mgrid[: SIZE * FINE, : SIZE * FINE] + 0.5) / FINE - 0.5
    whole = np.zeros((SIZE, SIZE))
    steps = 1 + int(2 * smear)
    for k in range(steps):
        dr, dc = rows - row - ((k + 0.5) / steps - 0.5) * smear, columns - column
        light = ground_of(rows)
        light = light - shadow * (np.hypot(dr - 0.9 * RADIUS, 0.5 * dc) < 0.6 * RADIUS)
        light = np.where(np.hypot(dr, dc) < radius, 0.8 - 0.5 * dr / radius, light)
        whole += light.reshape(SIZE, FINE, SIZE, FINE).mean(axis=(1, 3)) / steps
    noise = np.random.default_rng(int(100 * row)).normal(0.0, 0.005, whole.shape)
    return np.asarray(whole + noise)


def ground_of(rows: Floats) -> Floats:
    return np.asarray(np.where(rows > FLOOR_ROW, 0.45, 0.05))


def window(frame: int, picture: Floats) -> Window:
    rows = np.broadcast_to(np.arange(SIZE)[:, None], (SIZE, SIZE)).astype(np.float64)
    layers = [picture, ground_of(rows), np.ones_like(picture), np.zeros_like(picture)]
    return Window(frame, 0, 0, np.stack(layers))


def test_a_ball_is_placed_from_a_guess_that_lies_far_off_over_a_floor_as_bright_as_it() -> None:
    drawn = window(0, ball(48.3, 40.6))
    start = np.array([38.0, 36.0, RADIUS, 0.5, 1.0, 0.0, 0.0])
    found = fit_place(drawn.pixels, start, np.zeros((MAP_SIDE, MAP_SIDE)))
    assert found[5] > 0
    np.testing.assert_allclose(found[:2], (48.3, 40.6), atol=0.1)


def falling(exposure_s: float, shadow: float) -> tuple[list[Window], Motion]:
    """Draw twelve frames of a ball that comes nearer to the floor ever faster."""
    rows = np.linspace(26.0, 52.0, 12)
    speeds = np.zeros((12, 2))
    speeds[:, 0] = np.linspace(1400.0, 2400.0, 12)
    places = np.stack([rows, np.full(12, 40.2)], axis=1)
    deep = np.where(rows > FLOOR_ROW, shadow, 0.0)
    windows = [
        window(k, ball(row, 40.2, exposure_s * speed, dark))
        for k, (row, speed, dark) in enumerate(
            zip(rows.tolist(), speeds[:, 0].tolist(), deep.tolist(), strict=True)
        )
    ]
    return windows, Motion(np.arange(12), places, speeds)


def test_a_shadow_under_the_ball_is_not_taken_for_its_smear() -> None:
    windows, motion = falling(1.2e-3, shadow=0.3)
    placer = Placer.new(RADIUS, 0.0)
    placer.blur_px = 0.4
    told = placer.learn_exposure(windows, motion, PERIOD_S)
    assert told is not None
    assert abs(placer.exposure_s - 1.2e-3) < 3e-4


@pytest.mark.parametrize("exposure_s", [0.6e-3, 1.2e-3])
@pytest.mark.parametrize("blur_px", [0.85, 1.7])
def test_an_exposure_that_a_blur_taken_too_wide_hides_is_within_twice_its_error(
    exposure_s: float, blur_px: float
) -> None:
    """Rims are sharper than 0.4 px: the wider blur leaves no smear to be seen."""
    windows, motion = falling(exposure_s, shadow=0.0)
    placer = Placer.new(RADIUS, 0.0)
    placer.blur_px = blur_px
    told = placer.learn_exposure(windows, motion, PERIOD_S)
    assert told is not None
    assert abs(told[0] - exposure_s) < 2 * told[1] < 3e-3


def test_the_rim_of_a_sharp_film_is_not_taken_for_a_wide_one() -> None:
    windows, motion = falling(0.0, shadow=0.0)
    placer = Placer.new(RADIUS, 0.0)
    placer.learn_blur(windows, motion)
    assert placer.blur_px < 0.7


def test_a_ball_is_placed_in_blocks_of_pixels_where_it_is_in_the_pixels() -> None:
    windows, motion = falling(0.3 * PERIOD_S, 0.0)
    coarse = [
        Window(each.frame, 4, 6, _blocks(each.pixels[:, 4:, 6:], factor=2), 2) for each in windows
    ]
    fine, rough = (Placer.new(RADIUS, 0.3 * PERIOD_S) for _ in range(2))
    for placer, own in ((fine, windows), (rough, coarse)):
        placer.learn_blur(own, motion)
    places = [placer.place(w, motion).places for placer, w in ((fine, windows), (rough, coarse))]
    np.testing.assert_allclose(places[1], places[0], atol=0.08)


def _blocks(layers: Floats, factor: int) -> Floats:
    rows, columns = (side // factor for side in layers.shape[1:])
    starts = [layers[:, i::factor, j::factor] for i in range(factor) for j in range(factor)]
    return np.asarray(np.mean([each[:, :rows, :columns] for each in starts], axis=0))


def test_a_ball_that_comes_nearer_is_seen_to_grow_by_what_it_does() -> None:
    grown = np.linspace(-0.006, 0.006, 9)
    rows = np.linspace(20.3, 30.1, 9)
    places = np.stack([rows, np.full(9, 40.2)], axis=1)
    windows = [
        window(k, ball(row, 40.2, radius=RADIUS * (1.0 + own)))
        for k, (row, own) in enumerate(zip(rows.tolist(), grown.tolist(), strict=True))
    ]
    placer = Placer.new(1.003 * RADIUS, 0.0)
    placer.blur_px = 0.4
    motion = Motion(np.arange(9), places, np.zeros((9, 2)))
    found = by_radius(placer, (windows, motion, 0.0), placer.place(windows, motion))
    off = found.sizes[:, 0] - (grown - 0.003)
    assert np.abs(off - off.mean()).max() < 5 * found.sizes[:, 1].max() < 0.01
    # Its dark side moves less with the radius than the side that is seen.
    assert (found.shifts[:, 0] > 0).all()


def test_fingers_at_a_ball_that_is_let_go_are_not_taken_for_its_rim() -> None:
    windows, motion = falling(0.0, shadow=0.0)
    rows, columns = np.mgrid[:SIZE, :SIZE]
    for each in windows[:6]:
        # As bright as the ball, about all of it but the lower rim.
        row, column = motion.places[each.frame]
        away = np.hypot(rows - row + 4.0, columns - column)
        each.pixels[0][(away < 1.3 * RADIUS) & (away > RADIUS)] = 0.8
    placer = Placer.new(RADIUS, 0.0)
    placer.blur_px = 0.4
    assert not placer.learn_radius(windows, motion)
    assert placer.radius_px == RADIUS


def test_a_radius_up_to_which_misfits_fall_and_rise_again_is_none_of_the_ball() -> None:
    # Of a ball whose far side is dark, and of one before clutter, by RADII from 0.8 to 1.32.
    assert falls_to(1.22, [9.0, 5.0, 2.0, 1.0, 0.8, 0.6, 0.3, 0.5])
    assert falls_to(0.88, [0.6, 0.5, 0.8, 1.0, 1.3, 2.0, 3.0, 4.0])
    assert not falls_to(1.22, [2.1, 1.8, 1.4, 1.0, 0.9, 0.93, 0.7, 0.73])


def growing(grown: Floats) -> tuple[list[Window], Floats]:
    """Draw frames of a ball above the floor that is larger than RADIUS by these shares."""
    rows = np.linspace(20.3, 30.1, len(grown))
    places = np.stack([rows, np.full(len(grown), 40.2)], axis=1)
    sizes = (RADIUS * (1.0 + grown)).tolist()
    drawn = [ball(row, 40.2, radius=own) for row, own in zip(rows.tolist(), sizes, strict=True)]
    return [window(k, picture) for k, picture in enumerate(drawn)], places


def test_a_ball_that_comes_nearer_is_placed_where_it_is_once_its_size_is_known() -> None:
    grown = np.linspace(-0.08, 0.08, 9)
    windows, places = growing(grown)
    placer = Placer.new(RADIUS, 0.0)
    placer.blur_px = 0.4
    motion = Motion(np.arange(9), places, np.zeros((9, 2)))
    alike = placer.place(windows, motion).places - places
    sized = placer.place(windows, replace(motion, larger=grown)).places - places
    # Its dark lower rim is hardly seen: a radius that is too large takes the place with it.
    assert np.ptp(alike[:, 0]) > 0.6
    assert np.abs(sized).max() < 0.06


def test_places_with_sizes_of_their_own_are_given_on_as_if_with_one_radius() -> None:
    grown = np.linspace(-0.006, 0.006, 9)
    windows, places = growing(grown)
    placer = Placer.new(RADIUS, 0.0)
    placer.blur_px = 0.4
    seen = []
    for larger in (None, grown, 0.5 * grown):
        motion = Motion(np.arange(9), places, np.zeros((9, 2)), larger)
        placed = placer.place(windows, motion)
        found = by_radius(placer, (windows, motion, 0.0), placed)
        seen.append(observed_of(placed, np.arange(9.0), found))
    for other in seen[1:]:
        np.testing.assert_allclose(other.places, seen[0].places, atol=0.01)
        assert other.sizes is not None
        np.testing.assert_allclose(other.sizes[:, 0], grown, atol=3e-3)
