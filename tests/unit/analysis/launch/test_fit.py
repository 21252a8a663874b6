"""Fits of launches against the simulated rig, whose physics is its own."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from analysis.effects.catalogue import LAUNCH_CATALOGUE
from analysis.errors import LaunchRefusedError
from analysis.launch.compared import compare
from analysis.launch.fit import fit_launch, fit_touches, misfires
from analysis.launch.measurement import measured_touches
from analysis.launch.result import LaunchFit
from analysis.launch.scatter import KINDS, variance_component
from analysis.model.fitting.fit import fit_campaign
from tests.unit.analysis.launch.fired import SIGMA, TUBE, Faults, fired
from tests.unit.analysis.model.hard_spheres import campaign, draw

SPHERE_KG = 1150.0 * np.pi / 6 * 0.0254**3


@cache
def fitted(seed: int = 1) -> LaunchFit:
    touches, settings = fired(120, seed)
    return fit_touches(touches, settings)


def pull(found: LaunchFit, name: str, true: float) -> float:
    quantity = found.parameters()[name]
    return (quantity.value - true) / quantity.sigma


def test_pushers_and_tubes_come_back_within_their_errors() -> None:
    gain = 2 * TUBE.piston_area_m2 * 1000 * TUBE.stroke_m / SPHERE_KG
    friction = TUBE.friction_n / TUBE.piston_area_m2 / 1000
    coast = 0.0127 - TUBE.stroke_m
    truth = {
        **{"gain_a": gain, "gain_b": gain, "mouth": TUBE.mouth_m, "middle": 0.0},
        **{"push": 2 * TUBE.stroke_m + coast, "height_x": TUBE.height_m, "height_z": 0.0},
        **{"pressure-friction.p_a": friction, "pressure-friction.p_b": friction},
        **{f"tilt_{sphere}_{axis}": 0.0 for sphere in "ab" for axis in "xz"},
        **{"shift_x": 0.0, "shift_z": 0.0},
    }
    assert set(truth) == set(fitted().parameters())
    pulls = [pull(fitted(seed), name, true) for seed in (1, 2, 3) for name, true in truth.items()]
    assert np.abs(pulls).max() < 4
    assert 0.7 < np.std(pulls) < 1.3
    assert all(fitted(seed).converged for seed in (1, 2, 3))


def test_the_scatter_of_each_quantity_is_that_of_the_tubes() -> None:
    truth = {
        "speed": TUBE.speed_scatter,
        **{f"slope {axis}": TUBE.direction_scatter_rad for axis in "XZ"},
        **{f"spin {axis}": TUBE.spin_scatter_rad_per_s for axis in "XYZ"},
        **{f"track offset {axis}": TUBE.position_scatter_m * np.sqrt(2) * 1e3 for axis in "XZ"},
        **{f"track height {axis}": TUBE.position_scatter_m / np.sqrt(2) * 1e3 for axis in "XZ"},
        "lag": TUBE.valve_jitter_s * np.sqrt(2) * 1e6,
    }
    for seed in (1, 2):
        spread = fitted(seed).spread()
        assert set(spread) == set(truth)
        for name, true in truth.items():
            # A part of each variance is the measurement's: its error adds to that of the scatter.
            assert abs(spread[name].value - true) < 4 * max(spread[name].sigma, 0.06 * true), name


CASES = {
    "pressure-hysteresis": (Faults(hysteresis=0.01), [0.01]),
    "pressure-leak": (Faults(leak=1e-3), [1e-3]),
    "launch-delay": (Faults(delay_s=4e-4), [4e-4]),
    "tube-spin": (Faults(rolling=0.4), [0.4]),
    "slide-backlash": (Faults(backlash_m=1e-4), [1e-4]),
}


@pytest.mark.parametrize("name", CASES)
def test_an_effect_in_the_rig_is_brought_back_by_a_fit_with_it(name: str) -> None:
    effects = {effect.name: effect for effect in LAUNCH_CATALOGUE}
    faults, true = CASES[name]
    touches, settings = fired(120, 4, faults)
    found = fit_touches(touches, settings, (effects["pressure-friction"], effects[name]))
    assert found.converged
    size = len(true)
    sigma = np.sqrt(np.diag(found.covariance))[-size:]
    assert np.abs((found.theory.vector[-size:] - true) / sigma).max() < 3.5
    assert (np.abs(true) > 3 * sigma).all()


def test_one_pressure_leaves_friction_to_its_range_and_still_foretells_the_speed() -> None:
    touches, settings = fired(40, 5, pressures=(50.0,))
    found = fit_touches(touches, settings)
    assert found.parameters()["pressure-friction.p_a"].sigma > 3
    speeds = found.compared.speed
    assert speeds.mean() == pytest.approx(np.abs(touches.rows[:, [1, 4]]).mean(), rel=5e-3)


def test_shots_without_spins_are_fitted_by_their_tracks() -> None:
    touches, settings = fired(60, 6)
    covariance = touches.covariance.copy()
    covariance[:, range(6, 12), range(6, 12)] = 1e8
    found = fit_touches(replace(touches, covariance=covariance), settings)
    assert found.converged
    assert found.spread()["spin Z"].value == 0.0
    assert found.spread()["speed"].value == pytest.approx(TUBE.speed_scatter, rel=0.35)


def test_misfires_are_left_out_and_named() -> None:
    touches, settings = fired(80, 9)
    clear = fit_touches(touches, settings)
    rows = touches.rows.copy()
    rows[10, 1] *= 0.6
    rows[40, 15] += 0.2
    found = fit_touches(replace(touches, rows=rows), settings)
    assert found.rejected.tolist() == [11, 41]
    assert found.shots.size == 78
    assert clear.rejected.size == 0
    for name, quantity in clear.spread().items():
        assert found.spread()[name].value == pytest.approx(quantity.value, rel=0.1)


def test_many_strange_shots_are_the_theory_s_fault() -> None:
    touches, settings = fired(80, 9)
    clear = fit_touches(touches, settings)

    def strange(every: int) -> np.ndarray:
        rows = touches.rows.copy()
        rows[::every, 1] *= 0.6
        found = compare(clear.theory, settings, replace(touches, rows=rows))
        return misfires(replace(clear, compared=found))

    assert np.flatnonzero(strange(10)).tolist() == list(range(0, 80, 10))
    assert not strange(4).any()


def test_too_few_shots_are_refused() -> None:
    touches, settings = fired(4, 1)
    with pytest.raises(LaunchRefusedError, match="4 shots, 5 are needed"):
        fit_touches(touches, settings)


def test_a_pressure_of_nothing_is_refused() -> None:
    touches, settings = fired(6, 1)
    settings.pressure_kpa[2, 1] = 0.0
    with pytest.raises(LaunchRefusedError, match="a pressure of 0 kPa"):
        fit_touches(touches, settings)


def test_a_variance_component_solves_its_equation() -> None:
    rng = np.random.default_rng(8)
    variance, shape = rng.uniform(0.5, 2.0, 400), rng.uniform(1.0, 3.0, 400)
    residual = np.sqrt(variance + (1.5 * shape) ** 2) * rng.normal(size=400)
    found = variance_component(residual, variance, shape, 400.0)
    assert found == pytest.approx(1.5, abs=0.2)
    assert (residual**2 / (variance + (found * shape) ** 2)).sum() == pytest.approx(400.0)


def test_residuals_below_their_errors_have_no_scatter() -> None:
    assert variance_component(np.full(9, 0.5), np.ones(9), np.ones(9), 9.0) == 0.0


def test_every_number_of_a_muzzle_belongs_to_one_kind() -> None:
    assert sorted(c for kind in KINDS for c in kind.columns) == list(range(17))


def test_states_of_a_fit_of_poses_have_the_errors_that_are_stated() -> None:
    seed, shots = 21, 60
    data = campaign(shots, seed)
    touches = measured_touches(data, fit_campaign(data))
    drawn = draw(np.random.default_rng(seed), shots)
    true = np.concatenate(
        [
            drawn.velocity.reshape(shots, 6),
            drawn.spin.reshape(shots, 6),
            np.zeros((shots, 3)),
            drawn.normal[:, [0, 2]],
        ],
        axis=1,
    )
    sigma = np.sqrt(np.diagonal(touches.covariance, axis1=1, axis2=2))
    pulls = (touches.rows - true) / sigma
    assert np.abs(pulls.mean()) < 0.15
    assert pulls.std(axis=0) == pytest.approx(np.ones(17), abs=0.35)
    assert touches.time_s == pytest.approx(drawn.contact_s, abs=1e-4)


def test_poses_and_covariates_are_all_that_a_fit_needs() -> None:
    """Speeds made to follow a law of the pressure: the gain comes back from the poses."""
    seed, shots = 22, 30
    data = campaign(shots, seed)
    drawn = draw(np.random.default_rng(seed), shots)
    settings = {
        "pressure_a_kpa": drawn.velocity[:, 0, 1] ** 2 / 0.08 + 4.0,
        "pressure_b_kpa": drawn.velocity[:, 1, 1] ** 2 / 0.10 + 6.0,
        "offset_mm": drawn.normal[:, 0] * 25.4,
    }
    data = replace(data, covariates={**data.covariates, **settings})
    found = fit_launch(data, fit_campaign(data)).parameters()
    for name, true in (("gain_a", 0.08), ("gain_b", 0.10)):
        assert found[name].value == pytest.approx(true, rel=0.02)
    assert found["pressure-friction.p_a"].value == pytest.approx(4.0, abs=1.0)
    assert found["pressure-friction.p_b"].value == pytest.approx(6.0, abs=1.0)


def test_errors_of_the_measurement_enter_as_stated() -> None:
    """Touches measured five times worse scatter as they did."""
    touches, settings = fired(120, 7)
    worse = replace(
        touches,
        rows=touches.rows + np.sqrt(24) * SIGMA * np.random.default_rng(1).normal(size=(120, 17)),
        covariance=25 * touches.covariance,
    )
    clear, noisy = fit_touches(touches, settings), fit_touches(worse, settings)
    for name in ("speed", "spin X", "slope Z"):
        one, other = clear.spread()[name], noisy.spread()[name]
        assert abs(one.value - other.value) < 4 * other.sigma
