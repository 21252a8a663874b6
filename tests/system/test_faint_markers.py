"""Spheres whose markers take a quarter of the light: learned as they are, or refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from analysis.campaign import analyse_campaign, read_campaign
from analysis.shot import AnalysisOptions, MeasuredShot, RefusedShot
from simulators.world import WorldDescription, write_campaign
from simulators.world.description import Sphere
from simulators.world.optics import Optics

OPTICS = Optics(exposure_s=5e-5, noise_grey=2.0)
PRESSURES, OFFSETS = [60.0, 40.0, 80.0], [3.0, 8.0, 6.0]


def measured(folder: Path, reflectance: float) -> list[MeasuredShot | RefusedShot]:
    sphere = Sphere(marker_reflectance=reflectance)
    world = WorldDescription(optics=OPTICS, sphere_a=sphere, sphere_b=sphere)
    write_campaign(folder, PRESSURES, OFFSETS, 4, description=world, state_scale=False)
    done = analyse_campaign(read_campaign(folder), AnalysisOptions(), workers=1)
    return [shot for _, shot, _ in done]


@pytest.mark.parametrize("reflectance", [pytest.param(0.6, marks=pytest.mark.long), 0.75])
def test_faint_markers_come_out_as_dark_as_they_are(tmp_path: Path, reflectance: float) -> None:
    shots = measured(tmp_path / "faint", reflectance)
    truths = json.loads((tmp_path / "faint" / "truth.json").read_text(encoding="utf-8"))["shots"]
    for shot, truth in zip(shots, truths, strict=True):
        assert isinstance(shot, MeasuredShot), shot
        assert shot.known is not None
        darkness = [sphere.darkness for sphere in shot.known.spheres]
        assert darkness == pytest.approx([1.0 - reflectance] * 2, rel=0.1)
        e, v_n = shot.impact.e, shot.impact.v_n
        assert abs(e.value + truth["v_n_after"] / truth["v_n"]) < max(0.006, 3.0 * e.sigma)
        assert abs(v_n.value - truth["v_n"]) < 3.5 * v_n.sigma
        scale = np.mean(list(shot.tracking.scales_px_per_m.values())) / OPTICS.scale_px_per_m - 1
        assert abs(scale) < max(0.0015, 3.0 * shot.tracking.scale_sigma)


def test_markers_that_take_next_to_nothing_leave_the_spins_open(tmp_path: Path) -> None:
    shots = measured(tmp_path / "fainter", 0.97)
    truths = json.loads((tmp_path / "fainter" / "truth.json").read_text(encoding="utf-8"))["shots"]
    for shot, truth in zip(shots, truths, strict=True):
        assert isinstance(shot, MeasuredShot), shot
        assert shot.impact.v_s is None
        assert "spins are open" in shot.notes[0]
        e = shot.impact.e
        assert abs(e.value + truth["v_n_after"] / truth["v_n"]) < max(0.006, 3.0 * e.sigma)
