"""A shot measured from its written poses is the shot measured right after tracking."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analysis.campaign import ShotJob
from analysis.errors import ShotRefusedError
from analysis.exchange.contact_table import CONTACT_SIGMAS, contact_row, read_contacts
from analysis.exchange.folder import folder_writer
from analysis.model.data.gather import gather
from analysis.model.data.poses import PoseData
from analysis.motion.rotation import rotation_matrix
from analysis.results.from_poses import pose_impacts
from analysis.scene import Scene
from analysis.shot import MeasuredShot, analyse_shot
from analysis.shot_poses import ShotPoses
from analysis.two_sides import measure_two_sides
from simulators.world import WorldDescription
from tests.unit.analysis.rendered import setup_of, shot

SETUP = setup_of(WorldDescription())


@pytest.fixture(scope="module")
def measured() -> MeasuredShot:
    rendered = shot(40.0, 6.0, frames=14)
    analysed = analyse_shot(rendered.frames, rendered.times_s, SETUP)
    assert isinstance(analysed, MeasuredShot)
    return analysed


@pytest.fixture
def folder(tmp_path: Path, measured: MeasuredShot) -> Path:
    job = ShotJob(1, Path("frames/0001.tiff"), SETUP, None)
    with folder_writer(tmp_path / "written", "nylon", [job]) as write:
        write(1, measured)
    return tmp_path / "written"


def poses_of(measured: MeasuredShot) -> ShotPoses:
    return ShotPoses.of_tracks(measured.centres, measured.orientations, measured.times_s)


def test_written_poses_give_the_same_impact(folder: Path, measured: MeasuredShot) -> None:
    _, data = gather(folder / "poses.csv")
    assert isinstance(data, PoseData)
    found, impact = pose_impacts(data), measured.impact
    assert impact.v_s is not None
    assert impact.v_s_after is not None
    told = (impact.v_n, impact.v_s, impact.v_n_after, impact.v_s_after)
    assert found.velocities[0] == pytest.approx([q.value for q in told], rel=1e-9)
    sigma = np.sqrt(np.diag(found.covariance[0]))
    assert sigma == pytest.approx([q.sigma for q in told], rel=1e-6)


def test_written_contacts_have_the_error_of_each_number(
    folder: Path, measured: MeasuredShot
) -> None:
    with (folder / "contacts.csv").open() as file:
        [row] = csv.DictReader(file)
    written = [float(row[name]) for name in CONTACT_SIGMAS]
    assert written == measured.impact.state_sigma.ravel().tolist()


def test_a_written_contact_is_read_as_the_row_that_was_measured(
    folder: Path, measured: MeasuredShot
) -> None:
    [read] = read_contacts(folder / "contacts.csv", plate=False)
    row = contact_row(1, measured)
    assert read.normal == pytest.approx(row.normal, abs=1e-15)
    assert (read.before, read.after, read.errors) == (row.before, row.after, row.errors)
    assert row.before[:3] == tuple(measured.impact.before.velocity_a)


def test_without_orientations_restitution_is_as_it_was(measured: MeasuredShot) -> None:
    poses = poses_of(measured)
    blind = ShotPoses(
        *(poses.frames, poses.times_s, poses.position, poses.position_sigma, poses.rotation),
        np.full_like(poses.rotation_sigma, np.inf),
        poses.turn_shape,
    )
    found = measure_two_sides(blind, Scene.of(SETUP, measured.slow)).impact
    assert (found.v_s, found.v_s_after, found.beta) == (None, None, None)
    assert abs(found.e.value - measured.impact.e.value) < measured.impact.e.sigma
    assert np.isnan(found.before.spin_a).all()


def test_a_spin_is_as_unsure_as_the_axis_that_few_markers_leave_open(
    measured: MeasuredShot,
) -> None:
    """The same turns with the error about Y ten times the others, of the same mean square."""
    poses, scene = poses_of(measured), Scene.of(SETUP, measured.slow)
    weak = np.diag([1.0, 100.0, 1.0]) * 3.0 / 102.0
    round_, long_ = (
        measure_two_sides(
            replace(poses, turn_shape=np.broadcast_to(shape, poses.turn_shape.shape)), scene
        ).impact.state_sigma[:, 2:]
        for shape in (np.eye(3), weak)
    )
    assert (long_[..., 1] > 3.0 * round_[..., 1]).all()
    assert (long_[..., [0, 2]] < 1.5 * round_[..., [0, 2]]).all()


def test_spins_that_the_impulse_contradicts_are_not_measured(measured: MeasuredShot) -> None:
    """Sphere b is seen to turn by 100 rad/s more after the contact, as smoothly as it does."""
    poses, scene = poses_of(measured), Scene.of(SETUP, measured.slow)
    since = poses.times_s - measured.impact.contact_time.value
    turned = poses.rotation.copy()
    more = rotation_matrix(np.outer(np.maximum(since, 0.0), [0.0, 60.0, -80.0]))
    turned[:, 1] = more @ turned[:, 1]
    found = measure_two_sides(replace(poses, rotation=turned), scene)
    assert found.false_spins == ("b",)
    assert (found.impact.v_s, found.impact.v_s_after) == (None, None)
    assert abs(found.impact.e.value - measured.impact.e.value) < 0.1 * measured.impact.e.sigma
    assert measure_two_sides(poses, scene).false_spins == ()


@pytest.mark.parametrize("heights", [(2, 1), (1, 1), (0, 10)])
def test_heights_that_the_mirror_lacks_after_contact_follow_from_the_contact_and_the_momentum(
    measured: MeasuredShot, heights: tuple[int, int]
) -> None:
    """In some frames after contact, of a and b, the mirror's view shows the height of a shot."""
    poses, scene = poses_of(measured), Scene.of(SETUP, measured.slow)
    poses = replace(poses, rotation_sigma=np.full_like(poses.rotation_sigma, np.inf))
    whole = measure_two_sides(poses, scene).impact
    after = np.flatnonzero(np.isin(poses.frames, measured.used_after))
    sigma = poses.position_sigma.copy()
    for i, shown in enumerate(heights):
        sigma[after[shown:], i, 2] = np.inf
    found = measure_two_sides(replace(poses, position_sigma=sigma), scene)
    lacking = [f"{count} of the" for count in heights if count < 2]
    assert len(found.heights) == len(lacking)
    assert all(told in note for told, note in zip(lacking, found.heights, strict=True))
    for old, new, least, error in zip(
        (whole.after.velocity_a, whole.after.velocity_b),
        (found.impact.after.velocity_a, found.impact.after.velocity_b),
        whole.state_sigma[1, :2],
        found.impact.state_sigma[1, :2],
        strict=True,
    ):
        assert (np.abs(new - old) < 4.0 * np.hypot(least, error)).all()
    assert abs(found.impact.e.value - whole.e.value) < 3.0 * found.impact.e.sigma
    assert found.impact.e.sigma < 3.0 * whole.e.sigma


def test_a_lone_height_that_does_not_keep_the_momentum_is_refused(measured: MeasuredShot) -> None:
    poses, scene = poses_of(measured), Scene.of(SETUP, measured.slow)
    after = np.flatnonzero(np.isin(poses.frames, measured.used_after))
    sigma, position = poses.position_sigma.copy(), poses.position.copy()
    sigma[after[1:], 1, 2] = np.inf
    position[after[0], 1, 2] += 1e-3
    wrong = replace(poses, position_sigma=sigma, position=position)
    with pytest.raises(ShotRefusedError, match="off the one that keeps the momentum of both"):
        measure_two_sides(wrong, scene)


def test_changes_of_velocity_that_are_not_opposite_are_refused(measured: MeasuredShot) -> None:
    """After the contact the mirror shows something else, which moves at 0.4 m/s in depth."""
    poses, scene = poses_of(measured), Scene.of(SETUP, measured.slow)
    since = poses.times_s - measured.impact.contact_time.value
    position = poses.position.copy()
    position[:, 0, 2] += 0.4 * np.maximum(since, 0.0)
    with pytest.raises(ShotRefusedError, match=r"not opposite: along Z they are 0\.4"):
        measure_two_sides(replace(poses, position=position), scene)


def test_changes_of_velocity_are_opposite_for_any_masses(measured: MeasuredShot) -> None:
    a, b = SETUP.spheres
    heavy = replace(SETUP, spheres=(a, replace(b, density_kg_per_m3=3.0 * b.density_kg_per_m3)))
    found = measure_two_sides(poses_of(measured), Scene.of(heavy, measured.slow))
    assert found.impact.e.value == pytest.approx(measured.impact.e.value, abs=1e-3)


@pytest.mark.parametrize("of_b", [0, 1])
def test_a_contact_after_which_the_mirror_shows_one_height_at_most_is_refused(
    measured: MeasuredShot, of_b: int
) -> None:
    poses, scene = poses_of(measured), Scene.of(SETUP, measured.slow)
    after = np.flatnonzero(np.isin(poses.frames, measured.used_after))
    sigma = poses.position_sigma.copy()
    sigma[after, 0, 2] = sigma[after[of_b:], 1, 2] = np.inf
    with pytest.raises(ShotRefusedError, match="the top view shows sphere a in 0 of"):
        measure_two_sides(replace(poses, position_sigma=sigma), scene)


def test_no_poses_at_all_are_refused_in_words() -> None:
    none = np.empty((0, 2, 3))
    turns = np.empty((0, 2, 3, 3))
    empty = ShotPoses(
        *(np.empty(0, np.intp), np.empty(0), none, none), turns, np.empty((0, 2)), turns
    )
    scene = Scene.of(SETUP, SETUP.measurement)
    with pytest.raises(ShotRefusedError, match="no frame shows both spheres"):
        measure_two_sides(empty, scene)


@pytest.mark.parametrize("overlap_m", [-0.002, 0.002])
def test_tracks_that_part_long_before_or_after_their_kink_are_refused(
    measured: MeasuredShot, overlap_m: float
) -> None:
    poses, impact = poses_of(measured), measured.impact
    position = poses.position.copy()
    after = np.flatnonzero(np.isin(poses.frames, measured.used_after))
    first, since = after[0], poses.times_s[after] - poses.times_s[after[0]]
    # b leaves a at 0.1 m/s along the normal, from a place that overlaps a or is short of it.
    reach = sum(Scene.of(SETUP, measured.slow).radii) - overlap_m
    apart = (reach + 0.1 * since)[:, None] * impact.normal
    position[after, 1] = position[after, 0] + apart
    wrong = replace(poses, position=position)
    assert np.isfinite(poses.position_sigma[first]).all()
    with pytest.raises(ShotRefusedError, match="by their paths after it part at"):
        measure_two_sides(wrong, Scene.of(SETUP, measured.slow))
