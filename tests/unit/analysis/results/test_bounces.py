"""Bounces on a plate from poses, each from its two flights, against a ball that is simulated."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigctl
from analysis.model.data.gather import gather
from analysis.model.data.poses import PoseData
from analysis.results.from_poses import pose_impacts
from analysis.results.lines import fit_lines
from rigctl import cli
from simulators.challenge import drops
from simulators.challenge.drops import Drop
from tests.unit.analysis.model.dropped import write_drops

AIR = "drag_coefficient = 0.45\ndrag_coefficient_sigma = 0.02"
FALLEN = Drop(drag_coefficient=0.45, friction=0.15, tilt=(0.004, -0.003))


def written(
    folder: Path, monkeypatch: pytest.MonkeyPatch, drop: Drop = FALLEN, **thrown: Any
) -> list[float]:
    """Write a campaign of one long throw after another; return the e of all bounces in order."""
    true, simulated = list[float](), drops.bounce

    def watched(drop: Drop, met: drops.Body) -> tuple[drops.Body, float]:
        left, took = simulated(drop, met)
        true.append(float(-(left.velocity @ drop.normal) / (met.velocity @ drop.normal)))
        return left, took

    monkeypatch.setattr(drops, "bounce", watched)
    write_drops(folder, drop, **thrown)
    return true


def test_poses_of_a_ball_on_a_plate_give_e_of_each_bounce(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    thrown = {"shots": 6, "seed": 3, "rate_hz": 500.0, "sigma_m": 4e-5, "air": AIR}
    true = written(tmp_path, monkeypatch, **thrown)
    shots = rigctl.open(tmp_path).measure()
    table = shots.table()
    assert len(shots) == len(true)
    assert not shots.left_out
    pulls = (np.asarray(table["e"]) - true) / np.asarray(table["sigma_e"])
    assert np.abs(pulls).max() < 3.0
    # A ball that flies beside the plate says little of e where nobody states how the plate leans.
    assert np.asarray(table["sigma_e"]).min() < 0.002
    assert (np.asarray(table["v_s"]) > 0.1).all()
    sliding = np.asarray(table["beta"]) < 0.3
    assert np.asarray(table["f"])[sliding] == pytest.approx(0.15, abs=0.006)


@pytest.mark.long
def test_bounces_on_a_plate_are_drawn_and_reported_with_their_lines(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    true = written(tmp_path, monkeypatch, shots=6, seed=3, sigma_m=4e-5, air=AIR)
    axes = rigctl.open(tmp_path).measure().plot()
    drawn = max(len(line.get_xdata()) for line in axes.lines)
    assert drawn >= len(true)
    report = tmp_path / "report.html"
    assert cli.run(["report", str(tmp_path), "--out", str(report)]) == 0
    assert f"{len(true)} bounces of 6 shots measured" in report.read_text("utf-8")


def test_of_a_ball_without_markers_e_is_sure_and_stated_errors_are_not_needed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drop = Drop(drag_coefficient=0.45)
    thrown = {"shots": 6, "seed": 2, "rate_hz": 250.0, "sigma_m": 4e-5, "air": AIR}
    thrown |= {"sideways": 0.02, "spinning": 0.0, "markers": False, "lasts_s": 0.5}
    true = written(tmp_path, monkeypatch, drop, **thrown)
    table = rigctl.open(tmp_path).measure().table()
    e, sigma = (np.asarray(table[name]) for name in ("e", "sigma_e"))
    assert len(e) == len(true)
    assert (np.abs(e - true) < 3.0 * sigma).all()
    assert np.median(sigma) < 0.001
    # What gravity adds while contacts last, all bounces have alike: a mean is no surer of it.
    data = gather(tmp_path)[1]
    assert isinstance(data, PoseData)
    mean = fit_lines(pose_impacts(data)).parameters()["e"]
    assert abs(mean.value - np.mean(true)) < 2.0 * mean.sigma
    assert mean.sigma > 0.6 * sigma.min()
    assert np.isnan(np.asarray(table["v_s"])).all()
    head, *rows = (tmp_path / "poses.csv").read_text("utf-8").splitlines()
    bare = [",".join([*row.split(",")[:7], *[""] * 8]) for row in rows]
    (tmp_path / "poses.csv").write_text("\n".join([head, *bare, ""]), "utf-8")
    found = rigctl.open(tmp_path).measure().table()
    assert np.asarray(found["e"]) == pytest.approx(e, abs=3e-4)
    assert np.asarray(found["sigma_e"]) == pytest.approx(sigma, rel=0.4)


def test_flights_that_are_not_free_by_their_errors_are_left_out_with_the_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written(tmp_path, monkeypatch, shots=3, seed=3, sigma_m=4e-5, air=AIR, markers=False)
    data = gather(tmp_path)[1]
    assert isinstance(data, PoseData)
    sigma = data.position_sigma.copy()
    sigma[0] /= 30.0
    found = pose_impacts(data.with_sigmas(sigma, data.rotation_sigma))
    assert [one.shot for one in found.left_out] == [101]
    assert "not free" in found.left_out[0].reason
    assert found.shots.tolist() == data.shots[1:].tolist()
