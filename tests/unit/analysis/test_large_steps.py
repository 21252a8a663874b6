"""Beads that move by four of their radii from frame to frame, beside the world that drew them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from analysis.campaign import analyse_campaign, read_campaign
from analysis.shot import AnalysisOptions, MeasuredShot
from simulators.world import WorldDescription, write_campaign
from simulators.world.description import Sphere, Tube
from simulators.world.optics import Optics

BEAD = Sphere(diameter_m=2e-3, markers=12, marker_radius_rad=0.25)
WORLD = WorldDescription(
    sphere_a=BEAD,
    sphere_b=BEAD,
    # 1 m/s, which is four radii at 250 frames/s; they meet 30 ms from the mouths.
    tube=Tube(
        mouth_m=0.03,
        height_m=-0.0044,
        piston_area_m2=1e-7,
        stroke_m=6.02e-4,
        friction_n=0.0,
        position_scatter_m=2e-5,
        valve_jitter_s=1e-5,
    ),
    optics=Optics(
        rows=370,
        columns=600,
        scale_px_per_m=1e4,
        front_origin_px=(160.0, 300.0),
        top_origin_px=(50.0, 300.0),
        front_rows=(100, 370),
        top_rows=(0, 100),
        background_per_column=0.01,
    ),
)


@pytest.mark.parametrize("markers", [0, 12])
def test_both_beads_are_measured_in_every_shot(markers: int, tmp_path: Path) -> None:
    bead, folder = replace(BEAD, markers=markers), tmp_path / "beads"
    world = replace(WORLD, sphere_a=bead, sphere_b=bead)
    pressures, offsets = [40.0, 40.0], [0.2, 0.8]
    write_campaign(folder, pressures, offsets, 3, description=world, frame_rate_hz=250.0, frames=14)
    truths = json.loads((folder / "truth.json").read_text())["shots"]
    measured = analyse_campaign(read_campaign(folder), AnalysisOptions(), workers=1)
    for (_, shot, _), truth in zip(measured, truths, strict=True):
        assert isinstance(shot, MeasuredShot), shot
        assert len(shot.used_before) + len(shot.used_after) >= 11
        e, v_n = shot.impact.e, shot.impact.v_n
        assert abs(e.value + truth["v_n_after"] / truth["v_n"]) < min(4 * e.sigma, 0.02)
        assert abs(v_n.value - truth["v_n"]) < min(4 * v_n.sigma, 0.01 * abs(truth["v_n"]))
