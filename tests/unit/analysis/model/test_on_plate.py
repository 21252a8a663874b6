"""Poses of a ball that bounces on a plate: air, law and tilt of the plate from its flights."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from analysis.effects.catalogue import CATALOGUE
from analysis.errors import InputError
from analysis.exchange.pose_table import read_poses
from analysis.model.data.gather import gather
from analysis.model.data.plate import bounces_of
from analysis.model.data.poses import PoseData
from analysis.model.data.reading import stream_poses
from analysis.model.fitting.air import with_measured_air
from analysis.model.fitting.fit import START
from analysis.model.fitting.robust_fit import RobustFit, robust_fit
from analysis.model.predict.contact import contact_outcome, differentiated_contact
from analysis.model.predict.start import first_states
from analysis.model.predict.state import MOTION, SIZE, TILT
from analysis.model.predict.theory import Theory
from analysis.model.verdict.selection import Verdict, explain
from simulators.challenge.drops import Drop
from tests.unit.analysis.model.dropped import write_drops

FALLEN = Drop(drag_coefficient=0.45, friction=0.15, tilt=(0.004, -0.003))
VISCOUS = Drop(drag_coefficient=0.45, viscous=True)
LIGHT = Drop(radius_m=0.02, density_kg_per_m3=84.0, drag_coefficient=0.45)
"""A ball of table tennis: the air takes a tenth of its speed in a flight."""


@pytest.fixture(scope="module")
def marked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("drops") / "marked"
    return write_drops(folder, FALLEN, shots=10, seed=3, rate_hz=250.0, sigma_m=4e-5)


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("drops") / "plain"
    return write_drops(
        folder,
        VISCOUS,
        shots=16,
        seed=4,
        heights_m=(0.03, 0.6),
        sideways=0.02,
        spinning=1.0,
        markers=False,
        lasts_s=0.8,
        rate_hz=250.0,
        sigma_m=4e-5,
    )


def posed(folder: Path) -> PoseData:
    data = gather(folder)[1]
    assert isinstance(data, PoseData)
    return data


def test_each_bounce_is_an_impact_that_says_its_shot(marked: Path) -> None:
    data = posed(marked)
    assert {int(n) // 100 for n in data.shots} <= set(range(1, 11))
    assert len(data.shots) > len(read_poses(marked / "poses.csv"))
    assert data.on_plate


def test_no_frame_counts_in_two_bounces(marked: Path) -> None:
    for spheres in read_poses(marked / "poses.csv").values():
        used = [row.position for rows in bounces_of(spheres["a"]) for row in rows]
        assert len(used) == len(set(used))


@pytest.fixture(scope="module")
def few(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Enough shots for what no chance decides."""
    folder = tmp_path_factory.mktemp("drops") / "few"
    return write_drops(folder, FALLEN, shots=3, seed=3, rate_hz=250.0, sigma_m=4e-5)


@pytest.fixture(scope="module")
def fitted(few: Path) -> RobustFit:
    return robust_fit(posed(few))


@pytest.mark.long
def test_law_air_and_tilt_are_those_of_the_simulated_ball(marked: Path) -> None:
    verdict = explain(posed(marked), CATALOGUE)
    assert (verdict.verdict, verdict.effects) == ("effect", ("lasting-contact",))
    assert verdict.fit.chi2_per_dof == pytest.approx(1.0, abs=0.06)
    found, shared = verdict.fit.parameters(), verdict.fit.systematics()
    truth = {"mu": 0.15, "lasting-contact.kappa": 0.3, "lasting-contact.zeta": 0.05}
    for name, value in truth.items():
        assert abs(found[name].value - value) < 4 * found[name].sigma + 1e-3, name
    truth = {"drag.Cd": 0.45, "plate-tilt.y": 0.004, "plate-tilt.z": -0.003}
    for name, value in truth.items():
        assert abs(shared[name].value - value) < 4 * shared[name].sigma + 1e-4, name


@pytest.fixture(scope="module")
def explained(plain: Path) -> Verdict:
    """The verdict on the ball without markers."""
    return explain(posed(plain), CATALOGUE)


@pytest.mark.long
def test_a_ball_without_markers_shows_air_and_restitution_that_falls_with_speed(
    explained: Verdict,
) -> None:
    verdict = explained
    assert (verdict.verdict, verdict.effects) == ("effect", ("restitution-viscoelastic",))
    drag = verdict.fit.systematics()["drag.Cd"]
    assert drag.sigma < 0.05
    assert abs(drag.value - 0.45) < 4 * drag.sigma
    # What was not seen is not determined.
    assert np.isnan(verdict.fit.parameters()["mu"].value)


@pytest.fixture(scope="module")
def light(tmp_path_factory: pytest.TempPathFactory) -> PoseData:
    folder = tmp_path_factory.mktemp("drops") / "light"
    write_drops(
        folder,
        LIGHT,
        shots=6,
        seed=6,
        heights_m=(0.2, 0.6),
        sideways=0.02,
        spinning=0.0,
        lasts_s=1.0,
        rate_hz=250.0,
        markers=False,
        air="drag_coefficient = 0.5\ndrag_coefficient_sigma = 0.1",
    )
    return posed(folder)


def test_the_air_is_as_thick_for_a_ball_that_it_slows_down_much(light: PoseData) -> None:
    # With the speeds of lines beside the bounces, and one restitution for all, it is 0.441.
    assert with_measured_air(light).drag_coefficient == pytest.approx(0.45, abs=0.002)


@pytest.mark.long
def test_the_fit_finds_the_air_of_a_ball_that_it_slows_down_much(light: PoseData) -> None:
    # Along paths that the air does not bend it is 0.462.
    drag = robust_fit(light).fit.systematics()["drag.Cd"]
    assert drag.value == pytest.approx(0.45, abs=0.002)


@pytest.mark.long
def test_a_law_that_is_far_off_makes_no_flight_look_noisy(plain: Path) -> None:
    """The drag is pulled by eighty stated errors; about it flights would scatter nine times."""
    assert robust_fit(posed(plain)).evidence.noise[0] < 1.3


def test_slopes_by_a_kick_are_those_of_states_that_are_moved(plain: Path) -> None:
    """Beside a plate that leans; central differences of the outcome itself are the oracle."""
    data = posed(plain)
    states = first_states(data)
    flat = Theory(START, data.systematics)
    lean = [0.02 if name.startswith("plate-tilt") else 0.0 for name in flat.names]
    theory = flat.at(flat.vector + np.array(lean))
    assert states.kick is not None
    places = MOTION.start + 6 + 3 * states.kick.sphere[0] + np.arange(3)
    slopes = differentiated_contact(data, states, theory).by_state
    for place in places:
        step = np.zeros((data.count, SIZE))
        step[:, place] = 1e-3
        ahead, behind = (
            contact_outcome(data, states.moved(sign * step), theory) for sign in (1.0, -1.0)
        )
        found = slopes[:, :, place - TILT.start]
        assert found == pytest.approx((ahead - behind) / 2e-3, abs=1e-6)


@pytest.mark.long
def test_streamed_bounces_give_the_same_numbers(few: Path, fitted: RobustFit) -> None:
    memory, stream = fitted.fit, robust_fit(stream_poses(few)[1]).fit
    assert np.array_equal(memory.theory.vector, stream.theory.vector)
    assert memory.chi2 == stream.chi2


@pytest.mark.long
def test_what_makes_no_sense_on_a_plate_is_not_offered(explained: Verdict) -> None:
    offered = {c.effect.name for c in explained.ranking.candidates}
    assert not offered & {"mass-mismatch", "radius-mismatch"}
    assert {"wind", "gravity-value", "magnus-lift"} <= offered


def test_a_ball_that_only_rises_is_refused_with_what_is_missing(tmp_path: Path) -> None:
    folder = write_drops(tmp_path / "short", FALLEN, shots=3, seed=5, lasts_s=0.08)
    with pytest.raises(InputError, match="coming near a plate and leaving it"):
        gather(folder)


def test_the_fit_does_not_depend_on_where_a_shots_time_begins(few: Path, fitted: RobustFit) -> None:
    rows = next(iter(read_poses(few / "poses.csv").values()))["a"]
    first, again = bounces_of(rows), bounces_of(rows[3:])
    assert [row.t_s for row in first[0]][3:] == [row.t_s for row in again[0]]
    assert fitted.fit.converged
