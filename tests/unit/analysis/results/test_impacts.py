"""Impacts measured from poses and tables, against the collisions that made them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.model.data.gather import gather
from analysis.model.data.poses import PoseData
from analysis.model.data.tables import ContactTable
from analysis.results.from_poses import pose_impacts
from analysis.results.from_table import table_impacts
from analysis.results.impacts import measured_impacts
from tests.unit.analysis.model.hard_spheres import RADIUS, Hidden, campaign, collided, draw
from tests.unit.analysis.model.tabulated import PLATE, contacts
from tests.unit.analysis.model.tabulated import impacts as scalar_folder

Floats = NDArray[np.float64]

LAW = (0.74, 0.08, 0.5)
SHOTS, SEED = 80, 23


def velocities_of(seed: int, shots: int) -> Floats:
    """Return the true v_n, v_s, v_n', v_s' of a drawn campaign, shot by shot in plain vectors."""
    drawn = draw(np.random.default_rng(seed), shots)
    velocity, spin = collided(drawn.velocity, drawn.spin, drawn.normal, LAW)
    rows = []
    for s, n in enumerate(drawn.normal):
        sides = []
        for v, w in ((drawn.velocity[s], drawn.spin[s]), (velocity[s], spin[s])):
            relative = v[1] - v[0]
            surface = relative - (relative @ n) * n + RADIUS * np.cross(n, w[0] + w[1])
            sides.append((relative @ n, surface))
        (v_n, surface), (v_n_after, leaving) = sides
        v_s = np.linalg.norm(surface)
        rows.append([v_n, v_s, v_n_after, leaving @ surface / v_s])
    return np.array(rows)


def whitened(found: Floats, truth: Floats, covariance: Floats) -> Floats:
    return np.linalg.solve(np.linalg.cholesky(covariance), (found - truth)[..., None])[..., 0]


def test_velocities_from_poses_err_as_their_covariance_says() -> None:
    data = campaign(SHOTS, SEED, LAW)
    found = pose_impacts(data)
    truth = velocities_of(SEED, SHOTS)[found.shots - 1]
    white = whitened(found.velocities, truth, found.covariance)
    np.testing.assert_allclose((white**2).mean(axis=0), 1, atol=4 * np.sqrt(2 / len(truth)))
    np.testing.assert_allclose(white.mean(axis=0), 0, atol=4 / np.sqrt(len(truth)))
    assert found.lever == pytest.approx(3.5)


def test_a_shot_is_measured_by_itself_whatever_the_others_say() -> None:
    """Another law in all other shots, or no other shot at all, changes no digit of it."""
    data, other = campaign(20, SEED, LAW), campaign(20, SEED, (0.4, 0.3, -0.2))
    chosen = np.arange(20) == 3
    found = pose_impacts(data)
    alone = data.of_shots(chosen)
    for company in (alone, PoseData.joined([other.of_shots(~chosen), alone])):
        among = pose_impacts(company)
        place = list(among.shots).index(4)
        np.testing.assert_array_equal(among.velocities[place], found.velocities[3])
        np.testing.assert_array_equal(among.covariance[place], found.covariance[3])


def test_a_shot_without_orientations_has_its_normal_velocities_alone() -> None:
    data = campaign(12, SEED, LAW)
    rotation_sigma = data.rotation_sigma.copy()
    rotation_sigma[3, :, 1] = np.inf
    blind = data.with_sigmas(data.position_sigma, rotation_sigma)
    found = pose_impacts(blind)
    assert list(np.flatnonzero(~found.surface)) == [3]
    truth = velocities_of(SEED, 12)[3]
    off = (found.velocities[3] - truth)[[0, 2]]
    assert (np.abs(off) < 4 * np.sqrt(np.diag(found.covariance[3])[[0, 2]])).all()


def test_a_table_of_contacts_gives_the_velocities_with_their_errors(tmp_path: Path) -> None:
    _, table = gather(contacts(tmp_path, SHOTS, SEED, LAW))
    assert isinstance(table, ContactTable)
    found = table_impacts(table)
    white = whitened(found.velocities, velocities_of(SEED, SHOTS), found.covariance)
    np.testing.assert_allclose((white**2).mean(axis=0), 1, atol=4 * np.sqrt(2 / SHOTS))


def test_published_scalars_are_taken_as_they_stand(tmp_path: Path) -> None:
    _, table = gather(scalar_folder(tmp_path, 6, 3, sigma=0.02))
    assert isinstance(table, ContactTable)
    found = table_impacts(table)
    np.testing.assert_array_equal(found.velocities, table.numbers)
    np.testing.assert_allclose(found.covariance, np.tile(4e-4 * np.eye(4), (6, 1, 1)))


def test_on_a_plate_friction_has_the_lever_of_one_sphere(tmp_path: Path) -> None:
    _, table = gather(scalar_folder(tmp_path, 6, 3, description=PLATE))
    assert isinstance(table, ContactTable)
    assert table_impacts(table).lever == pytest.approx(3.5)


def test_what_is_no_measured_impact_is_left_out_with_its_reason() -> None:
    data = campaign(4, SEED)
    velocities = np.array(
        [[-2.0, 1, 1.4, 0.2], [np.nan] * 4, [-0.01, 2, 0.01, 2], [-1, 1, np.nan, np.nan]]
    )
    covariance = np.tile(1e-4 * np.eye(4), (4, 1, 1))
    found = measured_impacts(data.shots, velocities, covariance, data.bodies)
    assert list(found.shots) == [1]
    reasons = {one.shot: one.reason for one in found.left_out}
    assert "pass each other by" in reasons[2]
    assert reasons[3] == "its approach, 0.0100 ± 0.0100 m/s, is not told from zero"
    assert "after contact" in reasons[4]


def test_a_wild_frame_is_left_out_of_its_shot_and_changes_no_other() -> None:
    data = campaign(SHOTS, SEED, LAW)
    sound = pose_impacts(data)
    assert sound.left_out == ()
    position = data.position.copy()
    position[7, 3, 0, 1] += 4e-4
    position[9, 4, :, 1] += 5e-3
    found = pose_impacts(replace(data, position=position))
    assert found.left_out == ()
    touched = np.isin(sound.shots, [8, 10])
    np.testing.assert_array_equal(found.velocities[~touched], sound.velocities[~touched])
    sigma = np.sqrt(np.diagonal(sound.covariance, axis1=1, axis2=2))
    assert (np.abs(found.velocities - sound.velocities) < 2 * sigma)[touched].all()


def test_a_shot_whose_poses_are_no_free_flights_is_left_out_with_its_misfit() -> None:
    data = campaign(20, SEED, LAW)
    position, since = data.position.copy(), data.times_s[7] - data.times_s[7, 0]
    position[7, :, 0, 1] += 2e-4 * np.sin(2000 * since)
    found = pose_impacts(replace(data, position=position))
    (bent,) = found.left_out
    assert bent.shot == 8
    assert "no free flight" in bent.reason


def test_errors_that_nobody_stated_are_the_scatter_about_free_flight() -> None:
    data = campaign(20, SEED, LAW)
    guessed = data.with_sigmas(5 * data.position_sigma, 5 * data.rotation_sigma)
    found = pose_impacts(replace(guessed, estimated=True))
    stated = pose_impacts(data)
    ratio = np.sqrt(found.covariance[:, 0, 0] / stated.covariance[:, 0, 0])
    assert np.median(ratio) == pytest.approx(1.0, abs=0.15)


def test_one_shot_of_five_frames_a_side_without_orientations_has_its_restitution() -> None:
    data = campaign(1, SEED, LAW)
    [before] = np.flatnonzero(np.diff(np.sign(np.diff(data.position[0, :, 0, 1]))) != 0)[:1]
    frames = slice(int(before) - 4, int(before) + 8)
    arrays = ("position", "position_sigma", "rotation", "rotation_sigma")
    few = replace(
        data,
        times_s=data.times_s[:, frames],
        **{name: getattr(data, name)[:, frames] for name in arrays},
    )
    found = pose_impacts(
        few.with_sigmas(few.position_sigma, np.full_like(few.rotation_sigma, np.inf))
    )
    assert list(found.surface) == [False]
    truth = velocities_of(SEED, 1)[0]
    off = (found.velocities[0] - truth)[[0, 2]]
    assert (np.abs(off) < 4 * np.sqrt(np.diag(found.covariance[0])[[0, 2]])).all()


def test_where_most_flights_are_bent_it_is_physics_and_none_is_left_out() -> None:
    data = campaign(20, SEED, LAW, hidden=Hidden(drag=3.0))
    found = pose_impacts(data)
    assert found.left_out == ()
    assert len(found.shots) == 20
