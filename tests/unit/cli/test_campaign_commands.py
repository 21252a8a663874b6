"""Campaigns and shots from the command line, without a daemon."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rigctl.cli import BAD_INPUT, NOT_FOUND, REFUSED, run

DESCRIPTION = """format = 1
name = "nylon"
[camera]
frame_rate_hz = 1000.0
width_px = 24
height_px = 16
[[spheres]]
name = "a"
diameter_m = 0.0254
[[spheres]]
name = "b"
diameter_m = 0.0254
"""
IMPACTS = "shot,v_n,v_s,v_n_after,v_s_after\n1,-3,1,2,0.5\n2,-3.1,1.1,2.1,0.6\n"

Answer = Callable[..., tuple[int, Any]]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    made = tmp_path / "exchange"
    made.mkdir()
    (made / "campaign.toml").write_text(DESCRIPTION)
    (made / "shots.csv").write_text("shot\n1\n2\n")
    (made / "impacts.csv").write_text(IMPACTS)
    return made


@pytest.fixture
def ask(capsys: pytest.CaptureFixture[str]) -> Answer:
    def answer(*arguments: str) -> tuple[int, Any]:
        capsys.readouterr()
        code = run(list(arguments))
        said = capsys.readouterr()
        return code, json.loads(said.out) if code == 0 else said.err

    return answer


def test_a_folder_is_imported_and_exported(folder: Path, ask: Answer, tmp_path: Path) -> None:
    code, found = ask("import", str(folder), "--json")
    assert (code, found) == (
        0,
        {"campaign": "nylon", "shots": 2, "measured": 2, "to_analyse": 0},
    )
    code, found = ask("export", "nylon", "out", "--json")
    assert (code, found["shots"]) == (0, 2)
    for path in folder.iterdir():
        assert (tmp_path / "out" / path.name).read_bytes() == path.read_bytes()


def test_shots_are_excluded_by_the_numbers_of_their_campaign(folder: Path, ask: Answer) -> None:
    run(["import", str(folder)])
    run(["import", str(folder), "--name", "again"])
    _, found = ask("shots", "exclude", "2", "--campaign", "again", "--reason", "dirty", "--json")
    assert [(s["shot"], s["excluded"]) for s in found["shots"]] == [("i0002-000002", "dirty")]
    _, found = ask("shots", "list", "--excluded", "--json")
    assert [shot["shot"] for shot in found["shots"]] == ["i0002-000002"]
    _, found = ask("shots", "include", "i0002-000002", "--json")
    assert found["shots"][0]["excluded"] is None
    _, found = ask("shots", "exclude", "1", "2", "--reason", "dirty", "--json")
    assert [shot["shot"] for shot in found["shots"]] == ["i0001-000001", "i0001-000002"]


def test_shots_are_noted_and_tagged(folder: Path, ask: Answer) -> None:
    run(["import", str(folder)])
    _, found = ask("shots", "note", "1", "seen again", "--json")
    assert found["shots"][0]["note"] == "seen again"
    _, found = ask("shots", "tag", "1", "wet", "cold", "--json")
    assert found["shots"][0]["tags"] == ["cold", "wet"]
    _, found = ask("shots", "list", "--tag", "wet", "--campaign", "nylon", "--json")
    assert [shot["shot"] for shot in found["shots"]] == ["i0001-000001"]


def test_campaigns_are_listed_noted_and_tagged(folder: Path, ask: Answer) -> None:
    run(["import", str(folder)])
    run(["import", str(folder), "--name", "again"])
    _, found = ask("campaigns", "note", "nylon", "from another lab", "--json")
    assert found["campaigns"][0]["note"] == "from another lab"
    _, found = ask("campaigns", "tag", "nylon", "wet", "cold", "--json")
    assert found["campaigns"][0]["tags"] == ["cold", "wet"]
    _, tagged = ask("campaigns", "list", "--tag", "wet", "--json")
    assert [one["campaign"] for one in tagged["campaigns"]] == ["nylon"]
    _, found = ask("campaigns", "list", "--json")
    assert [(one["campaign"], one["note"]) for one in found["campaigns"]] == [
        ("again", None),
        ("nylon", "from another lab"),
    ]
    _, found = ask("campaigns", "note", "nylon", "--json")
    assert (found["campaigns"][0]["note"], found["campaigns"][0]["tags"]) == (
        None,
        ["cold", "wet"],
    )


def test_a_table_of_campaigns_is_printed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run(["import", str(folder)])
    capsys.readouterr()
    run(["campaigns", "note", "nylon", "cleaned [twice]"])
    head, row = capsys.readouterr().out.splitlines()
    assert head.split() == ["campaign", "shots", "last", "tags", "note"]
    assert row.split()[:2] == ["nylon", "2"]
    assert "cleaned [twice]" in row


def test_a_table_of_shots_is_printed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run(["import", str(folder)])
    run(["shots", "exclude", "1", "--reason", "the tube was dirty"])
    said = capsys.readouterr().out
    assert "campaign nylon: 2 shots, 2 of them measured" in said
    assert "the tube was dirty" in said


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("shots", "exclude", "9", "--reason", "x"), NOT_FOUND, "no such shot"),
        (("shots", "exclude", "1", "9", "--reason", "x"), NOT_FOUND, "no such shot"),
        (("shots", "exclude", "1", "--reason", " "), BAD_INPUT, "reason: is empty"),
        (("shots", "tag", "1", "two words"), BAD_INPUT, "'two words'"),
        (("campaigns", "note", "brass", "x"), NOT_FOUND, "no such campaign"),
        (("shots", "list", "--campaign", "brass"), NOT_FOUND, "there are nylon"),
        (("campaigns", "tag", "nylon", "two words"), BAD_INPUT, "'two words'"),
        (("import", "exchange"), REFUSED, "there is a campaign of this name"),
        (("import", "nowhere"), BAD_INPUT, "nowhere"),
        (("export", "brass", "out"), NOT_FOUND, "no such campaign"),
        (("export", "nylon", "exchange"), BAD_INPUT, "is there already"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_sentence_and_changes_nothing(
    folder: Path, ask: Answer, arguments: tuple[str, ...], code: int, words: str
) -> None:
    run(["import", str(folder)])
    before = ask("shots", "list", "--json")
    found, said = ask(*arguments)
    assert (found, words in said) == (code, True), said
    assert ask("shots", "list", "--json") == before


def test_a_folder_that_cannot_be_read_makes_no_store(folder: Path, ask: Answer) -> None:
    (folder / "campaign.toml").write_text("format = 2\n")
    code, said = ask("import", str(folder))
    assert (code, "format 2; this program reads format 1" in said) == (BAD_INPUT, True)
    assert not Path("data").exists()


def test_where_nothing_was_fired_there_are_no_shots(ask: Answer, folder: Path) -> None:
    code, said = ask("shots", "list")
    assert (code, "holds no shots" in said) == (NOT_FOUND, True)


def test_the_store_is_verified_and_backed_up(folder: Path, ask: Answer, tmp_path: Path) -> None:
    run(["import", str(folder)])
    code, found = ask("verify", "--json")
    assert (code, found["shots"], found["faults"], found["unchecked"]) == (0, 2, [], 0)
    code, found = ask("backup", "copy", "--json")
    assert (code, found["shots"], found["folder"]) == (0, 2, "copy")
    code, said = ask("backup", "copy")
    assert (code, "is there already" in said) == (BAD_INPUT, True)
    kept = tmp_path / "data" / "shots" / "i0001" / "folder" / "impacts.csv"
    kept.write_text(kept.read_text() + "\n")
    code, said = ask("verify")
    assert (code, "not what was stored" in said) == (REFUSED, True)
    code, said = ask("backup", "another")
    assert (code, "impacts.csv" in said) == (REFUSED, True)
    assert not (tmp_path / "another").exists()


def test_a_state_that_no_shot_has_ends_with_2_and_names_those_there_are(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["shots", "list", "--state", "flown"]) == BAD_INPUT
    said = " ".join(capsys.readouterr().err.split())
    assert "'flown'" in said
    assert "analysed" in said
    assert "interrupted" in said
