"""Of a folder with several stages a command says which table it takes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rigctl.cli import run
from tests.unit.analysis.model.exchange_folder import write_campaign
from tests.unit.analysis.model.hard_spheres import campaign
from tests.unit.analysis.model.tabulated import contacts


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with contacts.csv and poses.csv, as an analysis of frames writes it."""
    place = tmp_path_factory.mktemp("stages") / "measured"
    contacts(place, 8, 1)
    return write_campaign(place, campaign(8, 1))


def fitted(path: Path, capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    """Return degrees of freedom of a fit, and what stands on standard error."""
    assert run(["model", "fit", str(path), "--json"]) == 0
    said = capsys.readouterr()
    return json.loads(said.out)["degrees_of_freedom"], said.err


def test_the_later_stage_is_taken_and_named_with_the_poses_beside_it(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    of_table, said = fitted(folder, capsys)
    assert "contacts.csv is taken" in said
    assert f"name {folder / 'poses.csv'}" in said
    of_poses, silent = fitted(folder / "poses.csv", capsys)
    assert "is taken" not in silent
    assert of_poses > 10 * of_table


def test_where_one_stage_alone_is_there_nothing_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for place in (contacts(tmp_path / "c", 8, 1), write_campaign(tmp_path / "p", campaign(8, 1))):
        assert "is taken" not in fitted(place, capsys)[1]
