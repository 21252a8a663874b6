"""What has no information stays where it was: beta0 by its prior, a shot's number by itself."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.model.fitting.fit import fit_campaign, normal_equations
from analysis.model.fitting.normal import shot_steps, solve_blocks
from analysis.model.predict.state import SIZE
from tests.unit.analysis.model.hard_spheres import campaign


def test_where_every_contact_slides_beta0_is_not_determined_and_stays_what_was_believed() -> None:
    fit = fit_campaign(campaign(20, 4, (0.74, 0.002, 0.5)))
    assert fit.theory.law.beta0 == pytest.approx(0.6, abs=0.02)
    assert fit.parameters()["beta0"].concise() == "not determined"
    assert fit.parameters()["mu"].value == pytest.approx(0.002, abs=1e-3)


def test_a_block_is_solved_however_different_its_units() -> None:
    rng = np.random.default_rng(1)
    units = 10.0 ** rng.uniform(-5, 5, SIZE)
    root = rng.normal(size=(3, 40, SIZE))
    matrices = np.swapaxes(root, 1, 2) @ root * units[:, None] * units
    wanted = rng.normal(size=(3, SIZE, 2)) / units[:, None]
    assert solve_blocks(matrices, matrices @ wanted) * units[:, None] == pytest.approx(
        wanted * units[:, None], rel=1e-6, abs=1e-6
    )


def test_a_number_without_information_stays_put() -> None:
    matrices = np.diag([*[4.0] * (SIZE - 1), 0.0])[None]
    step = solve_blocks(matrices, np.array([[*[2.0] * (SIZE - 1), 0.0]])[..., None])[0, :, 0]
    assert step[:-1] == pytest.approx(0.5)
    assert step[-1] == 0.0


def test_damping_shortens_a_step_and_without_it_the_step_is_that_of_newton() -> None:
    data = campaign(5, 2)
    fit = fit_campaign(data)
    sums = normal_equations(data, fit.states.moved(np.full((5, SIZE), 1e-4)), fit.theory)
    newton = np.linalg.solve(sums.states, sums.state_gradient[..., None])[..., 0]
    assert shot_steps(sums, np.zeros(5)) == pytest.approx(newton, rel=1e-3, abs=1e-8)
    damped = shot_steps(sums, np.full(5, 1e3))
    scale = np.sqrt(np.diagonal(sums.states, axis1=1, axis2=2))
    assert (np.linalg.norm(damped * scale, axis=1) < np.linalg.norm(newton * scale, axis=1)).all()
