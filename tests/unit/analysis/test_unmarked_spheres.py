"""Spheres without markers, alike and unlike, held against the world that rendered them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from analysis.campaign import analyse_campaign, analyse_job, read_campaign
from analysis.imaging.views import View
from analysis.shot import AnalysisOptions, MeasuredShot
from benchmarks.pairs import KINDS, drawn_campaign
from simulators.world import WorldDescription, write_campaign
from simulators.world.description import Sphere

INCH_M = 0.0254
PLAIN = replace(Sphere(), markers=0)


def measured(
    folder: Path,
    a: Sphere,
    b: Sphere,
    pressure_kpa: float,
    *,
    state_scale: bool = True,
    pressure_b_kpa: float | None = None,
    offset_mm: float = 4.0,
) -> tuple[MeasuredShot, dict[str, float]]:
    world = WorldDescription(sphere_a=a, sphere_b=b)
    write_campaign(
        folder,
        [pressure_kpa],
        [offset_mm],
        5,
        pressures_b_kpa=[pressure_kpa if pressure_b_kpa is None else pressure_b_kpa],
        description=world,
        frames=24,
        state_scale=state_scale,
    )
    options = AnalysisOptions()
    ((_, shot, _),) = analyse_campaign(read_campaign(folder), options, workers=1)
    assert isinstance(shot, MeasuredShot), shot
    (truth,) = json.loads((folder / "truth.json").read_text())["shots"]
    return shot, truth


@pytest.mark.parametrize(
    ("diameter_a", "diameter_b", "pressure_kpa"),
    [
        (INCH_M, INCH_M, 50.0),
        (INCH_M, INCH_M / 2, 60.0),
        (INCH_M / 2, INCH_M, 40.0),
        # The smaller one is 13 pixels across and moves by three of its radii from frame to frame.
        (INCH_M, INCH_M / 3, 50.0),
    ],
)
def test_restitution_and_normal_velocity_need_no_markers(
    diameter_a: float, diameter_b: float, pressure_kpa: float, tmp_path: Path
) -> None:
    a, b = (replace(PLAIN, diameter_m=size) for size in (diameter_a, diameter_b))
    shot, truth = measured(tmp_path / "shot", a, b, pressure_kpa)
    e, v_n = shot.impact.e, shot.impact.v_n
    assert abs(e.value + truth["v_n_after"] / truth["v_n"]) < min(4 * e.sigma, 0.02)
    assert abs(v_n.value - truth["v_n"]) < min(4 * v_n.sigma, 0.01 * abs(truth["v_n"]))
    assert e.sigma < 0.01


def test_what_needs_the_spin_is_open_and_said(tmp_path: Path) -> None:
    shot, _ = measured(tmp_path / "shot", PLAIN, PLAIN, 50.0)
    assert shot.impact.v_s is None
    assert shot.impact.beta is None
    assert "outlines alone, spins are open" in shot.notes[0]


def test_markers_too_few_for_a_spin_make_outlines_less_sure(tmp_path: Path) -> None:
    sure = {}
    for count in (0, 3):
        a = b = replace(Sphere(), markers=count)
        shot, truth = measured(tmp_path / str(count), a, b, 50.0)
        if count:
            assert "outlines alone, spins are open" in shot.notes[0]
        sure[count] = shot.impact.v_n.sigma
        assert abs(shot.impact.v_n.value - truth["v_n"]) < 4 * sure[count]
    assert sure[3] > 1.5 * sure[0]


def test_a_sphere_of_a_third_whose_markers_tell_no_turn_is_measured_by_its_outline(
    tmp_path: Path,
) -> None:
    # Its markers are 3 pixels wide, and it turns by more than that from frame to frame.
    smallest = replace(Sphere(), diameter_m=INCH_M / 3, marker_radius_rad=0.22)
    shot, truth = measured(tmp_path / "shot", Sphere(), smallest, 30.0)
    e, v_n = shot.impact.e, shot.impact.v_n
    assert "outlines alone, spins are open: " in shot.notes[0]
    assert abs(e.value + truth["v_n_after"] / truth["v_n"]) < min(3 * e.sigma, 0.02)
    assert abs(v_n.value - truth["v_n"]) < min(3 * v_n.sigma, 0.01 * abs(truth["v_n"]))
    # Markers that cross a limb of 7 pixels radius shift its circle by a third of a pixel.
    assert shot.slow.position_m * shot.tracking.scales_px_per_m[View.FRONT] > 0.2


def test_a_small_sphere_that_the_mirror_does_not_show_after_contact_keeps_the_momentum(
    tmp_path: Path,
) -> None:
    # Met far off its middle, the small one flies on beneath the large one, which hides it.
    small = replace(PLAIN, diameter_m=INCH_M / 3)
    shot, truth = measured(
        tmp_path / "shot", PLAIN, small, 55.0, pressure_b_kpa=7.6, offset_mm=11.0
    )
    e, v_n = shot.impact.e, shot.impact.v_n
    assert "shows sphere b in 0 of the" in str(shot.notes)
    assert "keeps the momentum of both" in str(shot.notes)
    assert abs(e.value + truth["v_n_after"] / truth["v_n"]) < min(4 * e.sigma, 0.02)
    assert abs(v_n.value - truth["v_n"]) < min(4 * v_n.sigma, 0.01 * abs(truth["v_n"]))


def test_the_scale_of_unlike_spheres_comes_from_both_diameters(tmp_path: Path) -> None:
    small = replace(PLAIN, diameter_m=INCH_M / 2)
    shot, truth = measured(tmp_path / "shot", PLAIN, small, 40.0, state_scale=False)
    v_n = shot.impact.v_n
    assert 0.003 < v_n.sigma / abs(v_n.value) < 0.01
    assert abs(v_n.value - truth["v_n"]) < 3 * v_n.sigma


def test_marked_spheres_of_unlike_size_have_their_spins(tmp_path: Path) -> None:
    smaller = replace(Sphere(), diameter_m=INCH_M / 1.5)
    shot, truth = measured(tmp_path / "shot", Sphere(), smaller, 50.0)
    v_s, e = shot.impact.v_s, shot.impact.e
    assert v_s is not None
    assert abs(v_s.value - truth["v_s"]) < min(4 * v_s.sigma, 0.02)
    assert abs(e.value + truth["v_n_after"] / truth["v_n"]) < 4 * e.sigma


@pytest.mark.long
def test_a_sphere_whose_markers_are_taken_for_others_is_measured_by_its_outline(
    tmp_path: Path,
) -> None:
    drawn_campaign(tmp_path, KINDS["ratio 2, marked"], 3, 22)
    truth = json.loads((tmp_path / "truth.json").read_text())["shots"][1]
    shot, _ = analyse_job(read_campaign(tmp_path).jobs[1], AnalysisOptions())
    assert isinstance(shot, MeasuredShot), shot
    assert "by markers sphere b is" in shot.notes[0]
    e, v_n = shot.impact.e, shot.impact.v_n
    assert abs(e.value + truth["v_n_after"] / truth["v_n"]) < 3 * e.sigma
    assert abs(v_n.value - truth["v_n"]) < 3 * v_n.sigma
