"""Shots whose shutter stays open from picture to picture: spheres smeared by up to five pixels."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from analysis.campaign import analyse_campaign, read_campaign
from analysis.shot import AnalysisOptions, MeasuredShot
from simulators.world import WorldDescription, write_campaign
from simulators.world.optics import Optics
from simulators.world.truth import FilmedTruth

pytestmark = pytest.mark.long

PRESSURES, OFFSETS = [60.0, 35.0, 80.0, 50.0, 25.0], [3.0, 8.0, 6.0, 1.0, 12.0]
EXPOSURE_S = 0.95e-3
STEP_S = 1e-3

Judged = list[tuple[MeasuredShot, FilmedTruth]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder: Path = tmp_path_factory.mktemp("exposed") / "long"
    world = WorldDescription(optics=Optics(exposure_s=EXPOSURE_S))
    write_campaign(folder, PRESSURES, OFFSETS, 4, description=world, state_scale=False)
    return folder


@pytest.fixture(scope="module")
def judge(folder: Path) -> Callable[[], Judged]:
    def judge() -> Judged:
        truths = json.loads((folder / "truth.json").read_text(encoding="utf-8"))["shots"]
        done = analyse_campaign(read_campaign(folder), AnalysisOptions(), workers=1)
        pairs = []
        for (job, shot, _), truth in zip(done, truths, strict=True):
            assert isinstance(shot, MeasuredShot), (job.shot, shot)
            pairs.append((shot, truth))
        return pairs

    return judge


@pytest.fixture(scope="module")
def stated(judge: Callable[[], Judged]) -> Judged:
    return judge()


def test_restitution_and_approach_are_right_and_as_good_as_stated(stated: Judged) -> None:
    e = [s.impact.e.value + t["v_n_after"] / t["v_n"] for s, t in stated]
    e_pulls = [off / s.impact.e.sigma for off, (s, _) in zip(e, stated, strict=True)]
    v_n = [s.impact.v_n.value / t["v_n"] - 1.0 for s, t in stated]
    v_n_pulls = [(s.impact.v_n.value - t["v_n"]) / s.impact.v_n.sigma for s, t in stated]
    assert np.sqrt(np.mean(np.square(e))) < 0.002
    assert np.sqrt(np.mean(np.square(v_n))) < 0.002
    assert np.abs([*e_pulls, *v_n_pulls]).max() < 3.0


def test_no_frame_that_was_exposed_during_the_contact_is_used(stated: Judged) -> None:
    for shot, truth in stated:
        used = shot.times_s[[*shot.used_before, *shot.used_after]]
        assert (np.abs(used - truth["contact_time_s"]) > EXPOSURE_S / 2).all()


def test_without_a_stated_exposure_no_frame_is_used_that_may_show_the_contact(
    folder: Path, stated: Judged, judge: Callable[[], Judged]
) -> None:
    path = folder / "shots.csv"
    whole = path.read_text(encoding="utf-8")
    rows = list(csv.reader(whole.splitlines()))
    at = rows[0].index("exposure_us")
    try:
        path.write_text(
            "".join(",".join(row[:at] + row[at + 1 :]) + "\n" for row in rows), encoding="utf-8"
        )
        unstated = judge()
    finally:
        path.write_text(whole, encoding="utf-8")
    for shot, truth in unstated:
        used = shot.times_s[[*shot.used_before, *shot.used_after]]
        assert (np.abs(used - truth["contact_time_s"]) > STEP_S / 2).all()
        assert any("no exposure is stated" in note for note in shot.notes)
        assert shot.impact.e.value == pytest.approx(-truth["v_n_after"] / truth["v_n"], abs=0.01)
