"""Impulses that no coefficient sets: both spheres share them, and a campaign tells of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analysis.collision.operator import walton
from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.gather import gather_poses
from analysis.model.proposals.forms.impulses import IMPULSES, changed_outcome
from analysis.model.proposals.propose import propose
from simulators.challenge.campaign import run_campaign
from simulators.challenge.folder import write_folder
from simulators.challenge.launch import Settings, Touch
from simulators.challenge.nature import Nature
from simulators.challenge.unnamed import Dependence, Law
from tests.unit.analysis.model.proposals.hidden import proposed

PER_KELVIN = 0.03


def warmth(settings: Settings, touch: Touch, radius_m: float) -> np.ndarray:
    return np.asarray(settings.temperature_c - 23.0)


ACROSS = Law("impulse_t", "temperature_c", "linear", warmth, "1/K", "grip", PER_KELVIN)


@pytest.mark.parametrize("slot", IMPULSES)
def test_an_impulse_that_changes_leaves_both_momenta_where_they_were(slot: str) -> None:
    encounter = proposed(None)[1].encounter
    a, b = encounter.bodies
    plain = walton(encounter)
    shots = len(encounter.e)
    changed = changed_outcome(slot, plain, encounter, np.linspace(-0.2, 0.3, shots)).after
    kept = plain.after
    momentum = a.mass * (changed.velocity_a - kept.velocity_a)
    momentum += b.mass * (changed.velocity_b - kept.velocity_b)
    np.testing.assert_allclose(momentum, 0.0, atol=1e-15)
    # About the contact point the lever of each impulse is its own radius along the normal.
    turned = a.inertia * (changed.spin_a - kept.spin_a)
    lever = a.radius * np.cross(-encounter.normal, a.mass * (changed.velocity_a - kept.velocity_a))
    np.testing.assert_allclose(turned + lever, 0.0, atol=1e-15)


def test_the_impulse_along_the_normal_leaves_the_surfaces_as_fast_and_the_other_the_rebound() -> (
    None
):
    encounter = proposed(None)[1].encounter
    plain, tenth = walton(encounter), np.full(len(encounter.e), 0.1)

    def rebound(of: str) -> np.ndarray:
        after = changed_outcome(of, plain, encounter, tenth).after
        return ((after.velocity_b - after.velocity_a) * encounter.normal).sum(axis=1)

    approach = encounter.approach
    np.testing.assert_allclose(rebound("impulse_t"), encounter.e * approach, rtol=1e-12)
    np.testing.assert_allclose(
        rebound("impulse_n"), (1.1 * (1 + encounter.e) - 1) * approach, rtol=1e-12
    )


def test_a_grip_that_follows_the_temperature_is_proposed_as_the_impulse_across(
    tmp_path: Path,
) -> None:
    nature = replace(Nature(), dependence=Dependence(ACROSS, PER_KELVIN))
    write_folder(tmp_path / "grip", run_campaign(nature, 4, shots=60))
    found = propose(gather_poses(tmp_path / "grip")[1], (), CATALOGUE)
    assert found.accepted[0].form.group == ("impulse_t", "temperature_c")
    amplitude = found.accepted[0].freed.parameters()["proposal-1.a"]
    assert abs(amplitude.value - PER_KELVIN) < 4 * amplitude.sigma
