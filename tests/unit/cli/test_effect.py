"""rigctl effect, and effects of one's own beside the catalogue on the command line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from analysis.effects.catalogue import CATALOGUE, LAUNCH_CATALOGUE
from rigctl import cli
from tests.unit.analysis.effects.own_files import STRETCH, line_here, text_of, write
from tests.unit.analysis.model.exchange_folder import write_campaign
from tests.unit.analysis.model.hard_spheres import campaign

SHOWN = {"effect", "title", "stage", "parameters", "formula", "source", "gives_away"}
PARAMETER = {"symbol", "unit", "meaning", "off", "plausible", "one_sided"}
BROKEN = """\
def appear(position, camera, values):
    return position * (1.0 + values[1])  # HERE"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with one effect that works and one that does not."""
    effects = tmp_path / "effects"
    write(effects, text_of(STRETCH, name="stretch"), "stretch")
    write(effects, text_of(BROKEN, name="broken"), "broken")
    return effects


def answer(capsys: pytest.CaptureFixture[str], *arguments: object) -> dict[str, Any]:
    """Return the one JSON document that a command prints."""
    assert cli.run([*map(str, arguments), "--json"]) == 0
    return json.loads(capsys.readouterr().out, parse_constant=pytest.fail)


@pytest.mark.parametrize("stage", ["contact", "flight", "camera", "clock"])
def test_a_fresh_file_is_listed_and_shown_as_it_stands(
    stage: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fresh = tmp_path / "mine"
    assert cli.run(["effect", "new", "air-cushion", "--stage", stage, "--folder", str(fresh)]) == 0
    assert capsys.readouterr().out.startswith(str(fresh / "air-cushion.py"))
    listed = answer(capsys, "effect", "list", "--effects", fresh)
    assert listed["faults"] == []
    assert "air-cushion" in [e["effect"] for e in listed["effects"]]
    shown = answer(capsys, "effect", "show", "air-cushion", "--effects", fresh)
    assert shown["stage"] == stage
    assert shown["parameters"][0]["off"] == 0


def test_a_file_that_is_there_is_never_overwritten(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write(tmp_path, "mine", "air-cushion")
    assert cli.run(["effect", "new", "air-cushion", "--folder", str(tmp_path)]) == 2
    assert path.read_text() == "mine"
    assert f"{path}: is there already" in capsys.readouterr().err


NAMES = [
    "drag",
    "launch-delay",
    "Air",
    "air_cushion",
    "air cushion",
    "../air",
    "-air",
    "air-",
    "a--b",
    "1a",
    "",
    "x" * 65,
]


@pytest.mark.parametrize("name", NAMES)
def test_a_name_that_cannot_be_is_refused_and_nothing_is_written(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fresh = tmp_path / "mine"
    assert cli.run(["effect", "new", "--folder", str(fresh), "--", name]) == 2
    shown = capsys.readouterr()
    assert (shown.out, shown.err.count("\n")) == ("", 1)
    assert not fresh.exists()


def test_the_list_is_the_catalogue_with_all_that_effects_say_of_themselves(
    capsys: pytest.CaptureFixture[str],
) -> None:
    listed = answer(capsys, "effect", "list")
    assert [e["effect"] for e in listed["effects"]] == [
        e.name for e in (*CATALOGUE, *LAUNCH_CATALOGUE)
    ]
    for effect in listed["effects"]:
        assert set(effect) == SHOWN | {"confused_with", "variants"}
        assert all(effect[key] for key in SHOWN)
        assert all(set(parameter) == PARAMETER for parameter in effect["parameters"])


def test_the_list_for_people_names_stage_and_unit(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["effect", "list"]) == 0
    rows = capsys.readouterr().out.splitlines()
    [row] = [row for row in rows if row.split()[:1] == ["gravity-value"]]
    assert row.split()[1:4] == ["flight", "dg", "m/s^2"]


def test_an_effect_is_shown_with_what_gives_it_away(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["effect", "show", "frame-rate"]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "frame-rate: Frame rate" in shown
    assert "plausible -0.003 to 0.003, off at 0" in shown
    assert "gives away the fall under gravity by 2 r" in shown
    assert "confused with gravity-value" in shown


def test_an_effect_that_is_not_there_is_not_found(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["effect", "show", "ether"]) == 4
    assert "'ether'" in capsys.readouterr().err


def test_a_fault_is_told_and_the_rest_is_listed(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["effect", "list", "--effects", str(folder), "--json"]) == 0
    told = capsys.readouterr()
    document = json.loads(told.out)
    [fault] = document["faults"]
    line = line_here(text_of(BROKEN, name="broken"))
    assert set(fault) == {"path", "line", "effect", "what", "todo"}
    assert (fault["path"], fault["line"]) == (str(folder / "broken.py"), line)
    assert fault["effect"] == "broken"
    names = [effect["effect"] for effect in document["effects"]]
    assert "stretch" in names
    assert "broken" not in names
    assert told.err.startswith(f"rigctl: left out: {folder / 'broken.py'}, line {line}: broken: ")
    assert told.err.count("\n") == 1


@pytest.mark.parametrize(
    "command", [["effect", "show", "broken"], ["model", "fit", ".", "--with", "broken"]]
)
def test_a_command_that_needs_a_faulty_effect_says_its_fault(
    command: list[str], folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run([*command, "--effects", str(folder)]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert "broken: raised IndexError" in told.err


def test_a_folder_that_is_not_there_is_bad_input(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["effect", "list", "--effects", str(tmp_path / "nowhere")]) == 2
    assert "nowhere" in capsys.readouterr().err


def test_ones_own_effect_is_ranked_and_fitted_and_a_faulty_one_told(
    tmp_path: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shots = write_campaign(tmp_path / "shots", campaign(8, 3))
    options = ("--effects", folder)
    ranked = answer(capsys, "model", "rank", shots, *options)
    assert [fault["effect"] for fault in ranked["faults"]] == ["broken"]
    scores = {c["effect"]: c["score"] for c in ranked["candidates"]}
    assert scores["stretch"] == pytest.approx(scores["image-scale"], rel=1e-6)
    fitted = answer(capsys, "model", "fit", shots, *options, "--with", "stretch")
    assert fitted["parameters"]["stretch.a"]["unit"] == "1"
