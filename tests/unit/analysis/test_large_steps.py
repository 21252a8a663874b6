"""Beads that move by four of their radii from frame to frame, beside the world that drew them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.campaign import analyse_campaign, read_campaign
from analysis.imaging.views import View
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


def beside_truth(shot: MeasuredShot, truth: dict[str, Any]) -> NDArray[np.float64]:
    """Return row and column of a and b in the front view less the true ones, shape (2, n, 2)."""
    off, shown = [], set(shot.used_before).intersection(*(own.frames for own in shot.centres))
    for i, own in enumerate(shot.centres):
        true = np.array([truth["centres_front_px"][k][i] for k in sorted(shown)])
        seen = own.position[np.isin(own.frames, list(shown)), :2] * WORLD.optics.scale_px_per_m
        off.append(seen + WORLD.optics.front_origin_px - true)
    return np.array(off)


def test_errors_of_outlines_alone_are_those_of_one_sphere_against_the_other(tmp_path: Path) -> None:
    bead, folder = replace(BEAD, markers=0), tmp_path / "beads"
    world = replace(WORLD, sphere_a=bead, sphere_b=bead)
    pressures, offsets = [40.0] * 4, [0.2, 0.4, 0.6, 0.8]
    write_campaign(folder, pressures, offsets, 3, description=world, frame_rate_hz=250.0, frames=14)
    truths = json.loads((folder / "truth.json").read_text())["shots"]
    scatters, pulls = [], []
    for (_, shot, _), truth in zip(
        analyse_campaign(read_campaign(folder), AnalysisOptions(), workers=1), truths, strict=True
    ):
        assert isinstance(shot, MeasuredShot), shot
        # Over 500 pixels the columns of both views tell this better than radii of 10 pixels do.
        assert abs(shot.tracking.scales_px_per_m[View.TOP] / WORLD.optics.scale_px_per_m - 1) < 5e-4
        off = beside_truth(shot, truth)
        scale = WORLD.optics.scale_px_per_m
        stated_px = scale * float(np.median(shot.centres[0].sigma[:, :2]))
        between = off[1] - off[0]
        scatters.append(np.std(between, axis=0, ddof=1) / (np.sqrt(2) * stated_px))
        slow_px = np.sqrt(2) * scale * shot.slow.position_m
        pulls.append(
            between.mean(axis=0) / np.hypot(slow_px, stated_px * np.sqrt(2 / len(between)))
        )
    # Of some 48 differences and of 8 means.
    assert 0.75 < np.sqrt(np.mean(np.square(scatters))) < 1.3
    assert 0.6 < np.sqrt(np.mean(np.square(pulls))) < 1.7


@pytest.mark.parametrize("markers", [0, pytest.param(12, marks=pytest.mark.long)])
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
