"""The whole photometric way on rendered shots, against their truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.errors import ShotRefusedError
from analysis.motion.rotation import rotation_vector
from analysis.photometric.method import followed_film, measure_poses
from analysis.photometric.teaching import teach
from analysis.shot import AnalysisOptions, MeasuredShot, analyse_shot
from simulators.world import Launch, WorldDescription, render_shot
from simulators.world.lamp import Lamp
from tests.unit.analysis.rendered import setup_of

SEED = 11
WORLD = WorldDescription()
SETUP = setup_of(WORLD)


def rendered(shot, pressure, offset_mm):
    return render_shot(WORLD, Launch(pressure, pressure, offset_mm * 1e-3), SEED, shot=shot)


@pytest.fixture(scope="module")
def first():
    return rendered(1, 60.0, 5.0)


@pytest.fixture(scope="module")
def second():
    return rendered(2, 40.0, 9.0)


@pytest.fixture(scope="module")
def known(first):
    return teach([(first.frames, first.times_s, SETUP)])


def true_centres(shot, sphere):
    """m in rig axes by frame, not a number where the sphere is not there."""
    optics = WORLD.optics
    places = np.full((len(shot.frames), 3), np.nan)
    pairs = zip(shot.truth["centres_front_px"], shot.truth["centres_top_px"], strict=True)
    for k, (front, top) in enumerate(pairs):
        if front[sphere] is not None and top[sphere] is not None:
            row, column = front[sphere]
            places[k, 0] = (row - optics.front_origin_px[0]) / optics.scale_px_per_m
            places[k, 1] = (column - optics.front_origin_px[1]) / optics.scale_px_per_m
            places[k, 2] = -(top[sphere][0] - optics.top_origin_px[0]) / optics.scale_px_per_m
    return places


def true_turns(shot, sphere, frames):
    w, x, y, z = np.array([shot.truth["rotation_quaternion"][k][sphere] for k in frames]).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array([[np.asarray(c) for c in row] for row in rows]), -1, 0)


def test_a_known_pair_is_placed_to_a_fiftieth_of_a_pixel(second, known):
    tracking, _ = measure_poses(second.frames, second.times_s, SETUP, known)
    for i, centres in enumerate(tracking.centres):
        error = centres.position - true_centres(second, i)[centres.frames]
        error = error[np.isfinite(error).all(axis=1)] * WORLD.optics.scale_px_per_m
        assert len(error) > 15
        assert np.abs(error - np.median(error, axis=0)).max() < 0.06
        assert np.sqrt((error**2).mean()) < 0.03


def test_a_known_pair_turns_as_it_did(second, known):
    tracking, _ = measure_poses(second.frames, second.times_s, SETUP, known)
    for i, turned in enumerate(tracking.orientations):
        true = true_turns(second, i, turned.frames)
        body = turned.rotation.transpose(0, 2, 1) @ true
        u, _, vt = np.linalg.svd(body.mean(axis=0))
        error = rotation_vector(turned.rotation @ (u @ vt) @ true.transpose(0, 2, 1))
        assert np.degrees(np.sqrt((error**2).sum(axis=1).mean())) < 0.15


def test_one_pattern_and_one_body_frame_serve_all_shots(first, second, known):
    patterns = [
        measure_poses(shot.frames, shot.times_s, SETUP, known)[0].orientations[0].pattern
        for shot in (first, second)
    ]
    assert np.array_equal(*patterns)


def test_the_impact_is_measured_within_its_errors(second, known):
    options = AnalysisOptions(method="photometric")
    shot = analyse_shot(second.frames, second.times_s, SETUP, options, known)
    assert isinstance(shot, MeasuredShot), shot
    truth, impact = second.truth, shot.impact
    e = -truth["v_n_after"] / truth["v_n"]
    assert impact.e.value == pytest.approx(e, abs=max(4 * impact.e.sigma, 0.002))
    assert impact.v_n.value == pytest.approx(truth["v_n"], rel=2e-3)
    assert impact.v_s.value == pytest.approx(truth["v_s"], abs=0.02)


def test_other_spheres_are_refused_as_not_those_that_were_learned(known):
    strangers = render_shot(WORLD, Launch(60.0, 60.0, 4e-3), SEED + 1)
    with pytest.raises(ShotRefusedError, match="learned"):
        followed_film(strangers.frames, strangers.times_s, known)


@pytest.mark.parametrize("changed", ["sides", "a", "b"])
def test_spheres_that_were_changed_are_refused_too(second, known, changed):
    a, b = known.spheres
    mirrored = [replace(s, markers=s.markers * [-1.0, 1.0, 1.0]) for s in (a, b)]
    others = {"sides": (b, a), "a": (mirrored[0], b), "b": (a, mirrored[1])}
    with pytest.raises(ShotRefusedError, match="learned"):
        followed_film(second.frames, second.times_s, replace(known, spheres=others[changed]))


def test_changed_spheres_are_learned_anew(second, known):
    a, b = known.spheres
    _, learned = measure_poses(second.frames, second.times_s, SETUP, replace(known, spheres=(b, a)))
    assert learned is not known
    assert learned.spheres[0].markers.shape[1] == 3
    _, kept = measure_poses(second.frames, second.times_s, SETUP, learned)
    assert kept is learned


def test_a_shot_adds_the_markers_that_the_first_has_not_shown(second, known):
    tracking, more = measure_poses(second.frames, second.times_s, SETUP, known, extend=True)
    for i, sphere in enumerate(more.spheres):
        before = known.spheres[i].markers
        assert len(before) < len(sphere.markers) <= 16
        moved = np.degrees(np.arccos((sphere.markers[: len(before)] * before).sum(axis=1)))
        assert np.median(moved) < 1.0
    whole, _ = measure_poses(second.frames, second.times_s, SETUP, known)
    for better, plain in zip(tracking.orientations, whole.orientations, strict=True):
        assert (
            better.covariance.trace(axis1=1, axis2=2).mean()
            < plain.covariance.trace(axis1=1, axis2=2).mean()
        )
    _, same = measure_poses(second.frames, second.times_s, SETUP, more, extend=True)
    assert [len(s.markers) for s in same.spheres] == [len(s.markers) for s in more.spheres]


def test_one_shot_moves_nothing_that_several_have_taught(first, second, known):
    taught = teach([(each.frames, each.times_s, SETUP) for each in (first, second)])
    a, b = taught.spheres
    fewer = replace(taught, spheres=(replace(a, markers=a.markers[1:]), b))
    _, more = measure_poses(second.frames, second.times_s, SETUP, fewer, extend=True)
    found, kept = more.spheres[0], fewer.spheres[0]
    assert len(found.markers) == len(a.markers)
    assert found.markers[:-1] == pytest.approx(kept.markers, abs=1e-6)
    assert found.darkness == pytest.approx(kept.darkness, abs=1e-6)
    assert found.markers[-1] == pytest.approx(a.markers[0], abs=0.002)
    assert np.array_equal(more.spheres[1].markers, b.markers)
    assert more.camera is fewer.camera


@pytest.mark.long
def test_the_scale_is_off_within_its_error_in_any_light():
    """The simulator's scale; light that smooth shading does not hold makes it less sure."""
    free = replace(SETUP, camera=replace(SETUP.camera, scale_px_per_m=None))
    lamps = Lamp(strength=90.0, room=15.0, gloss=90.0, fill=Lamp(toward=(-0.3, 0.9, 0.4)))
    launches = [Launch(60, 60, 5e-3), Launch(40, 40, 9e-3), Launch(80, 80, 2e-3)]
    found = []
    for optics in (WORLD.optics, replace(WORLD.optics, lamp=lamps)):
        world = replace(WORLD, optics=optics)
        shots = [render_shot(world, own, SEED, shot=k) for k, own in enumerate(launches, start=1)]
        found.append(teach([(shot.frames, shot.times_s, free) for shot in shots]))
        scale = found[-1].camera.optics.scales[0] / optics.scale_px_per_m
        assert abs(scale - 1.0) < 3 * found[-1].scale_sigma < 0.006
    plain, lit = found
    assert lit.relief_share > 10 * plain.relief_share
    assert lit.scale_sigma > 2 * plain.scale_sigma


def test_empty_frames_are_refused(known):
    empty = np.full((12, 192, 240), 33, dtype=np.uint8)
    with pytest.raises(ShotRefusedError, match="no frame shows"):
        followed_film(empty, np.arange(12) * 1e-3, known)


def test_a_dead_row_does_not_spoil_a_known_pair(second, known):
    frames = second.frames.copy()
    frames[:, 140] = 0
    tracking, _ = measure_poses(frames, second.times_s, SETUP, known)
    for i, centres in enumerate(tracking.centres):
        error = centres.position - true_centres(second, i)[centres.frames]
        off = error - np.nanmedian(error, axis=0)
        assert np.nanmedian(np.abs(off / centres.sigma)) < 1.2
        assert np.nanmax(np.abs(error)) * WORLD.optics.scale_px_per_m < 0.2


def test_an_exchanged_pair_of_frames_is_refused(second, known):
    frames = second.frames.copy()
    frames[[4, 5]] = frames[[5, 4]]
    options = AnalysisOptions(method="photometric")
    assert not analyse_shot(frames, second.times_s, SETUP, options, known)
