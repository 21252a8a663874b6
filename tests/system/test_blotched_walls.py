"""Shots before a wall whose blotches have more edges than the spheres."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from analysis.campaign import analyse_campaign, read_campaign
from analysis.shot import AnalysisOptions, MeasuredShot
from simulators.world import WorldDescription, write_campaign
from simulators.world.lamp import Lamp
from simulators.world.optics import Optics
from simulators.world.truth import FilmedTruth

pytestmark = pytest.mark.long

WALL = Optics(texture_grey=24.0, exposure_s=5e-5, noise_grey=2.0, lamp=Lamp(limb_darkening=0.15))
PRESSURES, OFFSETS = [60.0, 40.0, 80.0, 90.0], [3.0, 8.0, 6.0, 1.0]


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> list[tuple[MeasuredShot, FilmedTruth]]:
    folder: Path = tmp_path_factory.mktemp("blotched") / "wall"
    world = WorldDescription(optics=WALL)
    write_campaign(folder, PRESSURES, OFFSETS, 4, description=world, state_scale=False)
    truths = json.loads((folder / "truth.json").read_text(encoding="utf-8"))["shots"]
    done = analyse_campaign(read_campaign(folder), AnalysisOptions(), workers=1)
    return [
        (shot, truth)
        for (_, shot, _), truth in zip(done, truths, strict=True)
        if isinstance(shot, MeasuredShot)
    ]


def test_spheres_are_found_by_their_motion(
    measured: list[tuple[MeasuredShot, FilmedTruth]],
) -> None:
    assert len(measured) >= len(PRESSURES) - 1


def test_what_is_measured_is_as_good_as_stated(
    measured: list[tuple[MeasuredShot, FilmedTruth]],
) -> None:
    for shot, truth in measured:
        e, v_n = shot.impact.e, shot.impact.v_n
        assert abs(e.value + truth["v_n_after"] / truth["v_n"]) < max(0.006, 3.0 * e.sigma)
        assert abs(v_n.value - truth["v_n"]) < 3.5 * v_n.sigma
    e_errors = [s.impact.e.value + t["v_n_after"] / t["v_n"] for s, t in measured]
    assert np.median(np.abs(e_errors)) < 0.006
