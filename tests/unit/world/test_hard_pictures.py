"""A camera at a finite distance, a lamp and a faulty sensor, against geometry by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulators.world.description import Sphere
from simulators.world.lamp import Lamp
from simulators.world.optics import Optics
from simulators.world.pinhole import mirror_height_m, seen_at
from simulators.world.render import Camera, through_lens
from simulators.world.sensor import Sensor
from simulators.world.state import Pose

OPTICS = Optics(
    noise_grey=0.0,
    exposure_s=0.0,
    blur_px=0.0,
    distance_m=0.92,
    background_per_row=0.0,
    background_per_column=0.0,
)
TURNED = np.array([1.0, 0.0, 0.0, 0.0])
PLAIN = np.empty((0, 3))
coordinates = st.tuples(*[st.floats(-0.02, 0.02)] * 3)


def picture(optics, centres, markers=PLAIN):
    spheres = [Sphere(), Sphere()]
    poses = [None if c is None else Pose(np.array(c), TURNED) for c in centres]
    return Camera(optics, spheres, [markers, markers]).expose(lambda _: poses, 0.0)


def disc_beside(optics, light, rows):
    """Return row, column and radius of the bright disc in some rows."""
    empty = Camera(optics, [Sphere()] * 2, [np.empty((0, 3))] * 2).expose(
        lambda _: [None, None], 0.0
    )
    share = (light - empty)[rows] / (light.max() - empty.mean())
    down, across = np.indices(share.shape)
    area = share.sum()
    middle = (share * down).sum() / area + rows.start, (share * across).sum() / area
    return *middle, np.sqrt(area / np.pi)


def test_the_origin_appears_where_it_is_stated_in_both_views():
    front, top = seen_at(OPTICS, np.zeros(3))
    assert front == pytest.approx(OPTICS.front_origin_px)
    assert top == pytest.approx(OPTICS.top_origin_px, abs=0.05)


@given(coordinates)
def test_a_camera_far_away_sees_as_one_at_infinity(point):
    far, infinite = replace(OPTICS, distance_m=1e6), replace(OPTICS, distance_m=None)
    for near, plain in zip(
        seen_at(far, np.array(point)), seen_at(infinite, np.array(point)), strict=True
    ):
        assert near == pytest.approx(plain, abs=0.05)


@given(coordinates)
def test_the_mirror_shows_the_image_behind_it(point):
    # A mirror at 45 degrees through X = -h exchanges X and Z: (X, Z) -> (-Z - h, -X - h).
    height = mirror_height_m(OPTICS)
    behind = np.array([-point[2] - height, point[1], -point[0] - height])
    assert seen_at(OPTICS, np.array(point))[1] == pytest.approx(
        seen_at(OPTICS, behind)[0], abs=1e-6
    )


def test_a_nearer_sphere_is_larger_and_the_mirror_shows_it_smaller():
    lamp = replace(OPTICS, lamp=Lamp(strength=0.0, room=150.0, limb_darkening=0.0))
    front, top = slice(92, 192), slice(0, 80)
    sizes = [
        disc_beside(lamp, picture(lamp, [(0.0, 0.0, z), None]), front)[2] for z in (0.0, 0.009)
    ]
    assert sizes[1] / sizes[0] == pytest.approx(0.92 / 0.911, rel=0.003)
    mirrored = disc_beside(lamp, picture(lamp, [(0.0, 0.0, 0.0), None]), top)[2]
    assert mirrored / sizes[0] == pytest.approx(0.92 / (0.92 + mirror_height_m(lamp)), rel=0.003)


def test_the_image_of_a_sphere_lies_where_its_centre_is_projected():
    lamp = replace(OPTICS, lamp=Lamp(strength=0.0, room=150.0, limb_darkening=0.0))
    place = (0.01, -0.03, 0.005)
    row, column, _ = disc_beside(lamp, picture(lamp, [place, None]), slice(96, 192))
    expected = seen_at(lamp, np.array(place))[0]
    assert (row, column) == pytest.approx(expected, abs=0.1)


def test_the_side_away_from_the_lamp_has_the_light_of_the_room_alone():
    lamp = Lamp(toward=(0.0, -1.0, 0.0), strength=100.0, room=20.0, limb_darkening=0.0)
    optics = replace(OPTICS, lamp=lamp)
    light = picture(optics, [(0.0, 0.0, 0.0), None])
    row, column = (round(value) for value in OPTICS.front_origin_px)
    assert light[row, column + 12] == pytest.approx(20.0, abs=0.1)
    # 12 of 20 pixels from the middle toward the lamp: n . s = 0.6.
    assert light[row, column - 12] == pytest.approx(20.0 + 100.0 * 12 / 20, abs=1.5)


def test_a_sphere_before_the_lamp_casts_its_shadow_on_the_other():
    lamp = Lamp(toward=(0.0, -1.0, 0.0), strength=100.0, room=20.0, limb_darkening=0.0)
    optics = replace(OPTICS, lamp=lamp)
    row, column = (round(value) for value in OPTICS.front_origin_px)
    alone = picture(optics, [None, (0.0, 0.015, 0.0)])
    behind = picture(optics, [(0.0, -0.015, 0.0), (0.0, 0.015, 0.0)])
    lit_side = (row, column + 24 - 14)
    assert alone[lit_side] > 80.0
    assert behind[lit_side] == pytest.approx(20.0, abs=1.0)


def test_gloss_shines_where_the_lamp_is_mirrored_and_markers_do_not_dull_it():
    lamp = Lamp(toward=(0.0, 0.0, 1.0), strength=0.0, room=10.0, gloss=90.0, limb_darkening=0.0)
    optics = replace(OPTICS, lamp=lamp)
    row, column = (round(value) for value in OPTICS.front_origin_px)
    for markers in (np.empty((0, 3)), np.array([[0.0, 0.0, 1.0]])):
        light = picture(optics, [(0.0, 0.0, 0.0), None], markers)
        assert light[row, column] > 85.0
        assert light[row, column + 15] < 15.0


def test_a_sensor_has_dead_rows_where_they_are_in_the_full_frame_and_clips_at_its_full_well():
    sensor = Sensor(dead_rows=(70, 100), dead_grey=7, full_grey=120)
    optics = replace(OPTICS, sensor=sensor)
    camera = Camera(optics, [Sphere()] * 2, [np.empty((0, 3))] * 2)
    poses = [Pose(np.zeros(3), TURNED), None]
    rng = np.random.default_rng(1)
    whole = camera.take(lambda _: poses, 0.0, rng)
    assert (whole[[70, 100]] == 7).all()
    assert whole.max() == 120
    middle = camera.take(lambda _: poses, 0.0, rng, rows=96)
    assert (middle[[70 - 48, 100 - 48]] == 7).all()


def test_corners_are_darker_by_the_stated_share():
    optics = replace(OPTICS, sensor=Sensor(corner_light=0.5))
    bright = picture(replace(optics, sensor=Sensor()), [None, None])
    dark = picture(optics, [None, None])
    assert dark[0, 0] / bright[0, 0] == pytest.approx(0.5, abs=0.05)
    assert dark[96, 120] == pytest.approx(bright[96, 120], rel=0.001)


def test_a_point_out_of_focus_is_an_even_disc_of_the_stated_radius():
    light = np.zeros((31, 31), dtype=np.float32)
    light[15, 15] = 1.0
    seen = through_lens(replace(OPTICS, defocus_px=3.5), light)
    assert seen.sum() == pytest.approx(1.0, rel=1e-4)
    assert seen[15, 15] == pytest.approx(1.0 / (np.pi * 3.5**2), rel=0.02)
    assert seen[15, 15 + 5] == 0.0


def test_light_flickers_about_its_mean_twice_in_a_period_of_mains():
    optics = replace(OPTICS, flicker=0.1)
    camera = Camera(optics, [Sphere()] * 2, [PLAIN] * 2)
    levels = [camera.expose(lambda _: [None, None], 1e-3 * k)[50, 50] for k in range(20)]
    assert np.mean(levels) == pytest.approx(OPTICS.background, rel=1e-4)
    assert max(levels) == pytest.approx(1.1 * OPTICS.background, rel=0.01)
    assert levels[:10] == pytest.approx(levels[10:], rel=1e-4)


def test_blotches_stand_still_behind_the_spheres():
    optics = replace(OPTICS, texture_grey=8.0)
    empty = picture(optics, [None, None])
    assert empty.std() == pytest.approx(8.0, rel=0.05)
    behind = picture(optics, [(0.0, 0.0, 0.0), None])
    assert np.array_equal(behind[:, :60], empty[:, :60])
    row, column = (round(value) for value in OPTICS.front_origin_px)
    plain = picture(OPTICS, [(0.0, 0.0, 0.0), None])
    assert behind[row, column] == pytest.approx(plain[row, column])


def test_counted_electrons_make_bright_pixels_noisier():
    optics = replace(OPTICS, background=100.0, sensor=Sensor(grey_per_electron=0.25))
    camera = Camera(optics, [Sphere()] * 2, [PLAIN] * 2)
    taken = camera.take(lambda _: [None, None], 0.0, np.random.default_rng(3))
    # 100 grey levels are 400 electrons: their scatter is 20, or 5 grey levels.
    assert taken.std() == pytest.approx(5.0, rel=0.02)


def test_a_bent_response_keeps_black_and_the_full_well():
    light = np.array([[0.0, 63.75, 255.0]], dtype=np.float32)
    assert Sensor(response=0.5).grey(light)[0] == pytest.approx([0.0, 127.5, 255.0])
