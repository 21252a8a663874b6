"""A product is found wherever its zeros lie, and one argument alone stays alone."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from analysis.arrays import Floats
from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.gather import gather_poses
from analysis.model.proposals.propose import propose
from simulators.challenge.campaign import run_campaign
from simulators.challenge.folder import write_folder
from simulators.challenge.launch import Settings, Touch
from simulators.challenge.nature import Nature
from simulators.challenge.unnamed import Dependence, Law
from tests.unit.analysis.model.proposals.hidden import SHOTS, proposed

ZERO_M_PER_S, ZERO_C = 1.0, 23.0
BOTH = ("e", "speed_n*temperature_c")


def _warm_and_fast(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return np.asarray(np.log(touch.approach / ZERO_M_PER_S) * (settings.temperature_c - ZERO_C))


def test_a_product_whose_zero_no_shot_comes_near_is_named_and_its_zeros_found() -> None:
    law = Law(*BOTH, "linear", _warm_and_fast, "1/K", "as ln(v_n / (1 m/s)) times warmth", 0.0)
    with TemporaryDirectory() as made:
        folder = Path(made) / "campaign"
        nature = Nature(dependence=Dependence(law, 2e-3))
        write_folder(folder, run_campaign(nature, 6, shots=SHOTS))
        found = propose(gather_poses(folder)[1], (), CATALOGUE)
    [one] = found.accepted
    assert one.form.group == BOTH
    speed, warmth = one.quantities["x0"], one.quantities["y0"]
    assert abs(speed.value - ZERO_M_PER_S) < 4 * speed.sigma
    assert abs(warmth.value - ZERO_C) < 4 * warmth.sigma


@pytest.mark.long
def test_one_argument_alone_is_named_alone() -> None:
    for seed in (3, 4):
        _, found = proposed("restitution-temperature", 2e-3, seed)
        assert [one.form.argument for one in found.accepted] == ["temperature_c"]
