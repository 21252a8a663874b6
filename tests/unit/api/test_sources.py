"""Where campaigns come from: folders with tables, and names in a store."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

import rigctl
from rigctl.cli import run
from simulators.world import write_campaign


def test_tables_are_taken_as_they_are(mystery: Path) -> None:
    shots = rigctl.open(mystery).measure()
    assert (len(shots), shots.now) == (40, 0)
    named = rigctl.open(mystery / "poses.csv")
    assert named.name == "mystery"
    assert len(named.measure()) == 40


def test_a_folder_without_anything_is_refused_with_what_is_looked_for(tmp_path: Path) -> None:
    with pytest.raises(rigctl.AnalysisInputError, match=r"campaign\.toml"):
        rigctl.open(tmp_path)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(rigctl.AnalysisInputError, match="no such file"):
        rigctl.open(tmp_path / "nothing.tiff")


def test_a_name_is_looked_up_in_the_store_of_the_configuration(
    mystery: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    folder = shutil.copytree(mystery, tmp_path / "copied")
    assert run(["import", str(folder), "--name", "stored"]) == 0
    campaign = rigctl.open("stored")
    assert len(campaign.measure()) == 40
    wanted = rigctl.open(mystery).fit().parameters
    found = campaign.fit().parameters
    assert {name: q.value for name, q in found.items()} == pytest.approx(
        {name: q.value for name, q in wanted.items()}, rel=1e-6
    )
    with pytest.raises(rigctl.NotFoundError, match="other"):
        rigctl.open("other").measure()


def test_what_an_exchange_folder_of_measured_frames_holds_is_taken(tmp_path: Path) -> None:
    write_campaign(tmp_path / "nylon", [40.0], [6.0], 3, frames=16)
    out = tmp_path / "measured"
    words = ["analyse", str(tmp_path / "nylon"), "--method", "thesis", "--out", str(out)]
    assert run(words) == 0
    shots = rigctl.open(out).measure()
    assert (len(shots), shots.now) == (1, 0)
