"""Rendered shots over the whole range of settings: what is measured, against what happened."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from analysis.campaign import analyse_campaign, read_campaign
from analysis.quantity import Quantity
from analysis.shot import AnalysisOptions, MeasuredShot
from simulators.world import write_campaign
from simulators.world.truth import FilmedTruth

SEED = 11
PRESSURES = np.linspace(20.0, 100.0, 12)
OFFSETS = (0.0, 13.0, 5.0, 18.0, 9.0, 2.0, 15.0, 7.0, 20.0, 11.0, 4.0, 16.0)
NUMBERS = ("v_n", "v_s", "v_n_after", "v_s_after", "e", "contact_time", "duration")


@dataclass(frozen=True, slots=True)
class Judged:
    """A measured shot beside its truth."""

    shot: MeasuredShot
    truth: FilmedTruth

    def measured(self, name: str) -> Quantity:
        quantity = getattr(self.shot.impact, name)
        assert isinstance(quantity, Quantity)
        return quantity

    def true(self, name: str) -> float:
        truth = self.truth
        if name == "e":
            return -truth["v_n_after"] / truth["v_n"]
        key = {"contact_time": "contact_time_s", "duration": "contact_duration_s"}.get(name, name)
        return float(truth[key])  # type: ignore[literal-required]

    def error(self, name: str) -> float:
        return self.measured(name).value - self.true(name)


@pytest.fixture(scope="module")
def judged(tmp_path_factory: pytest.TempPathFactory) -> list[Judged]:
    folder: Path = tmp_path_factory.mktemp("rendered") / "range"
    write_campaign(folder, PRESSURES.tolist(), OFFSETS, SEED)
    truths = json.loads((folder / "truth.json").read_text(encoding="utf-8"))["shots"]
    found = []
    done = analyse_campaign(read_campaign(folder), AnalysisOptions(), workers=1)
    for (job, shot, _), truth in zip(done, truths, strict=True):
        assert isinstance(shot, MeasuredShot), (job.shot, shot)
        assert truth["shot"] == job.shot
        found.append(Judged(shot, truth))
    return found


def rms(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def test_the_normal_velocity_is_right_within_half_a_per_cent(judged: list[Judged]) -> None:
    assert rms([j.error("v_n") / j.true("v_n") for j in judged]) < 0.005


@pytest.mark.parametrize(
    ("name", "limit"),
    [
        ("e", 0.006),
        ("v_s", 0.03),
        ("v_s_after", 0.03),
        ("contact_time", 5e-5),
        ("duration", 1e-5),
    ],
)
def test_each_number_is_right_within_its_bound(
    judged: list[Judged], name: str, limit: float
) -> None:
    assert rms([j.error(name) for j in judged]) < limit


def test_the_normal_is_right_within_three_tenths_of_a_degree(judged: list[Judged]) -> None:
    cosines = [float(j.shot.impact.normal @ np.array(j.truth["normal"])) for j in judged]
    assert rms([float(np.degrees(np.arccos(min(1.0, c)))) for c in cosines]) < 0.3


def test_stated_errors_are_the_real_ones(judged: list[Judged]) -> None:
    pulls = [j.error(name) / j.measured(name).sigma for name in NUMBERS for j in judged]
    assert 0.4 < rms(pulls) < 1.6
    assert max(abs(pull) for pull in pulls) < 5.0


def test_states_on_both_sides_are_those_of_the_world(judged: list[Judged]) -> None:
    velocities, spins = [], []
    for j in judged:
        for state, side in ((j.shot.impact.before, "before"), (j.shot.impact.after, "after")):
            true_v = j.truth[f"velocity_{side}"]  # type: ignore[literal-required]
            true_w = j.truth[f"spin_{side}"]  # type: ignore[literal-required]
            velocities += [state.velocity_a - true_v[0], state.velocity_b - true_v[1]]
            spins += [state.spin_a - true_w[0], state.spin_b - true_w[1]]
    assert rms(np.ravel(velocities).tolist()) < 0.02
    assert rms(np.ravel(spins).tolist()) < 4.0


def test_no_marker_is_mixed_up_with_another(judged: list[Judged]) -> None:
    for number, j in enumerate(judged, start=1):
        for i, turned in enumerate(j.shot.orientations):
            true = [j.truth["rotation_quaternion"][int(k)][i] for k in turned.frames]
            world = Rotation.from_quat(np.array(true), scalar_first=True)
            found = Rotation.from_matrix(turned.rotation)
            # Both turn by the same between any two frames; a mix-up jumps by half a radian.
            steps = (found[1:] * found[:-1].inv()) * (world[1:] * world[:-1].inv()).inv()
            assert np.degrees(steps.magnitude()).max() < 4.0, (number, "ab"[i])
            in_both_views = np.isfinite(j.shot.centres[i].sigma).all(axis=1)
            assert len(turned.frames) >= 0.9 * in_both_views.sum()
