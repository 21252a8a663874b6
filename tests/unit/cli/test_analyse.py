from __future__ import annotations

import gc
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from analysis.campaign import Campaign, ShotJob, analyse_campaign, read_campaign
from analysis.exchange.contact_table import read_contacts
from analysis.shot import AnalysisOptions, MeasuredShot
from rigctl import cli
from simulators.world import write_campaign


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One rendered shot, and the frames of another that no row names."""
    home = tmp_path_factory.mktemp("data") / "nylon"
    write_campaign(home, [40.0], [6.0], 3, frames=16)
    (home / "frames" / "0009.tiff").write_bytes(b"never listed")
    return home


@pytest.fixture
def broken(tmp_path: Path) -> Path:
    path = tmp_path / "0002.npy"
    path.write_bytes(b"no frames")
    return path


def test_frames_without_a_row_are_named_beside_the_results_and_in_them(
    campaign: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["analyse", str(campaign), "--json"]) == 0
    shown = capsys.readouterr()
    document = json.loads(shown.out)
    unlisted = str(campaign / "frames" / "0009.tiff")
    assert document["unlisted"] == [unlisted]
    assert [shot["status"] for shot in document["shots"]] == ["measured"]
    # A first analysis may say before that it compiles.
    assert shown.err.endswith(f"rigctl: frames without a row in shots.csv, left out: {unlisted}\n")


def test_a_folder_that_was_written_is_not_analysed_again(
    campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "measured"
    assert cli.run(["analyse", str(campaign), "--out", str(out)]) == 0
    capsys.readouterr()
    assert cli.run(["analyse", str(out)]) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err == (
        f"rigctl: {out}: the folder holds poses and no frames; `rigctl model` reads it\n"
    )


def test_a_request_of_which_no_frames_can_be_read_says_why_and_ends_with_2(
    broken: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "measured"
    arguments = ["analyse", str(broken), str(broken), "--json", "--out", str(out)]
    assert cli.run(arguments) == 2
    shown = capsys.readouterr()
    reasons = [shot["reason"] for shot in json.loads(shown.out)["shots"]]
    assert all("0002.npy: not a whole NPY file" in reason for reason in reasons)
    assert len(reasons) == 2
    assert shown.err == (
        "rigctl: 0002: none of its 2 shots is measured; the reason stands beside each shot\n"
    )
    assert not out.exists()


def test_one_shot_that_can_be_read_is_enough(
    campaign: Path, broken: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shot = campaign / "frames" / "0001.tiff"
    assert cli.run(["analyse", str(shot), str(broken), "--json"]) == 0
    shots = json.loads(capsys.readouterr().out)["shots"]
    assert [each["status"] for each in shots] == ["measured", "refused"]


@pytest.mark.parametrize(
    "option", [("--sigma-px", "1.5"), ("--samples", "4"), ("--matching", "pattern")]
)
def test_an_option_of_the_edges_is_refused_where_none_are_sought(
    campaign: Path, capsys: pytest.CaptureFixture[str], option: tuple[str, str]
) -> None:
    assert cli.run(["analyse", str(campaign), *option]) == 2
    told = capsys.readouterr().err
    assert option[0] in told
    assert "--method thesis" in told


MANY = 20


@pytest.fixture
def many(campaign: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """Let one shot be measured under many numbers; give how many were held as each was taken."""
    read = read_campaign(campaign)
    ((job, shot, frames),) = analyse_campaign(read, AnalysisOptions())
    assert isinstance(shot, MeasuredShot)
    held: list[int] = []

    def measured_again(
        campaign: Campaign, *_: Any, **__: Any
    ) -> Iterator[tuple[ShotJob, MeasuredShot, int]]:
        for each in campaign.jobs:
            held.append(sum(isinstance(other, MeasuredShot) for other in gc.get_objects()))
            yield each, replace(shot), frames

    jobs = tuple(replace(job, shot=number) for number in range(1, MANY + 1))
    longer = Campaign(read.name, jobs)
    monkeypatch.setattr("rigctl.cli.frames.analyse.read_campaign", lambda *_: longer)
    monkeypatch.setattr("rigctl.cli.frames.analyse.analyse_campaign", measured_again)
    # What is older is not gone through each time.
    gc.collect()
    gc.freeze()
    yield held
    gc.unfreeze()


@pytest.mark.parametrize("form", [["--json"], []])
def test_no_shot_is_held_once_it_is_written(
    campaign: Path,
    many: list[int],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    form: list[str],
) -> None:
    out = tmp_path / "measured"
    assert cli.run(["analyse", str(campaign), "--out", str(out), *form]) == 0
    assert len(many) == MANY
    # The one that is copied, and the one that is being printed.
    assert max(many) <= many[0] + 1
    assert [row.shot for row in read_contacts(out / "contacts.csv", plate=False)] == [
        *range(1, MANY + 1)
    ]
    shown = capsys.readouterr().out
    if form:
        assert [shot["shot"] for shot in json.loads(shown)["shots"]] == [*range(1, MANY + 1)]
    else:
        rows = [line.split() for line in shown.splitlines()]
        assert [row[0] for row in rows[3:-1]] == [str(number) for number in range(1, MANY + 1)]
        assert len({len(line) for line in shown.splitlines()[1:-1]}) == 1
