"""The report: one file, whole and the same each time, that says what was measured and what not."""

from __future__ import annotations

import base64
import csv
import hashlib
import io
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

from analysis.results.tables import tables
from rigctl.challenge import new
from rigctl.cli import run
from rigctl.cli.store.report import report
from rigctl.errors import AnalysisInputError, NotFoundError, StoreError
from rigctl.reports.campaign import measured_results
from rigctl.reports.page import page
from rigctl.reports.source import folder_source
from simulators.challenge.campaign import run_campaign
from simulators.challenge.folder import write_folder
from simulators.challenge.force_choice import Forces
from simulators.challenge.nature import Nature

FILES = {
    *("coefficients", "parameters", "figure-7-4", "figure-7-4-curves"),
    *("restitution", "residuals", "left-out"),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("reported") / "nylon"
    new(place, seed=4, strength="full", shots=12)
    return place


@pytest.fixture(scope="module")
def text(folder: Path) -> str:
    source = folder_source(folder)
    return page(source, measured_results(source))


class Tags(HTMLParser):
    """Collects what a page consists of."""

    def __init__(self) -> None:
        super().__init__()
        self.seen: list[str] = []
        self.open: list[str] = []
        self.attributes: list[tuple[str, str | None]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.append(tag)
        self.attributes += attrs
        if tag not in {"meta", "br"}:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.attributes += attrs

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_report_is_one_whole_file_that_loads_and_runs_nothing(text: str) -> None:
    tags = Tags()
    tags.feed(text)
    assert tags.open == []
    assert not {"script", "link", "img", "iframe", "object"} & set(tags.seen)
    assert tags.seen.count("svg") == 3
    for name, value in tags.attributes:
        assert not name.startswith("on")
        if name in {"href", "xlink:href", "src"}:
            assert value is not None
            assert value.startswith(("#", "data:text/csv"))
    assert "@import" not in text
    assert not re.findall(r"url\((?!#)", text)


def test_each_card_leads_with_the_estimate_of_the_smaller_error(folder: Path, text: str) -> None:
    found = measured_results(folder_source(folder))
    cards = re.findall("<b>([^<]+)</b><span>(e|μ|β₀), ", text)
    assert [symbol for _, symbol in cards] == ["e", "μ", "β₀"]
    for (shown, _), name in zip(cards, ("e", "mu", "beta0"), strict=True):
        both = [found.whole_fit[name], found.coefficients()[name]]
        assert shown == min(both, key=lambda one: one.sigma).concise()


def test_identifiers_within_the_figures_are_unique_and_found(text: str) -> None:
    names = re.findall(r'\bid="([^"]+)"', text)
    assert len(names) == len(set(names))
    used = set(re.findall(r"url\(#([^)]+)\)", text)) | set(re.findall(r'href="#([^"]+)"', text))
    assert used <= set(names)


def test_the_same_measurements_give_the_same_bytes(folder: Path, text: str) -> None:
    source = folder_source(folder)
    assert page(source, measured_results(source)) == text


def test_every_shot_stands_in_the_report_used_or_left_out(folder: Path, text: str) -> None:
    shots = (folder / "shots.csv").read_text().splitlines()[1:]
    body = text.partition("Coefficients of every shot")[2].partition("Apparatus")[0]
    listed = re.findall(r"<tr><td>(\d+)</td>", body)
    assert sorted(map(int, listed)) == sorted(int(row.split(",")[0]) for row in shots)


def test_the_hashes_are_those_of_the_files_that_were_read(folder: Path, text: str) -> None:
    for name in ("campaign.toml", "shots.csv", "poses.csv"):
        digest = hashlib.sha256((folder / name).read_bytes()).hexdigest()
        assert f"<td>{name}</td><td>{digest}</td>" in text


def test_each_link_saves_the_table_behind_its_figure(folder: Path, text: str) -> None:
    links = dict(re.findall(r'download="([\w-]+)\.csv" href="data:text/csv;base64,([^"]+)"', text))
    assert set(links) == FILES - {"left-out"}
    rows = list(csv.reader(io.StringIO(base64.b64decode(links["coefficients"]).decode())))
    found = tables(measured_results(folder_source(folder)))["coefficients"]
    assert rows == [[str(cell) for cell in row] for row in found]


def test_the_name_of_a_campaign_cannot_become_markup(folder: Path, tmp_path: Path) -> None:
    sly = tmp_path / "sly"
    sly.mkdir()
    for file in folder.glob("*.csv"):
        (sly / file.name).write_bytes(file.read_bytes())
    about = (folder / "campaign.toml").read_text()
    named = re.sub(r'^name = "nylon"', 'name = "<script>&"', about, count=1, flags=re.MULTILINE)
    assert named != about
    (sly / "campaign.toml").write_text(named)
    source = folder_source(sly)
    written = page(source, measured_results(source))
    assert "<script>" not in written
    assert "&lt;script&gt;&amp;" in written


def test_a_shot_that_a_person_excluded_is_named_with_the_reason(
    folder: Path, tmp_path: Path
) -> None:
    place = tmp_path / "nylon"
    place.mkdir()
    for file in ("campaign.toml", "poses.csv"):
        (place / file).write_bytes((folder / file).read_bytes())
    head, *rows = (folder / "shots.csv").read_text().splitlines()
    rows = [row + (",a hair in the tube" if row.startswith("3,") else ",") for row in rows]
    (place / "shots.csv").write_text(
        "\n".join([f"{head},excluded", *rows, "99" + "," * head.count(",") + ","]) + "\n"
    )
    source = folder_source(place)
    reasons = {one.shot: one.reason for one in source.missing}
    assert reasons[3] == "excluded by a person: a hair in the tube"
    assert "no measurement" in reasons[99]
    assert 3 not in measured_results(source).impacts.shots


@pytest.mark.long
def test_of_contacts_that_last_no_line_has_a_number_and_their_own_law_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place = tmp_path / "soft"
    nature = Nature(forces=Forces(), drag_coefficient=0.4)
    write_folder(place, run_campaign(nature, 5, shots=20))
    report(place, out=tmp_path / "r.html", csv=None, config=None)
    written = (tmp_path / "r.html").read_text(encoding="utf-8")
    rows = re.findall(r"<tr><td>(e|μ|β₀|kappa|zeta|t), [^<]*</td><td>([^<]*)</td>", written)
    told = dict(rows)
    assert told["μ"] == told["β₀"] == "no law of these contacts"
    assert re.fullmatch(r"0\.7\d+\(\d+\)", told["e"])
    assert {"t", "kappa", "zeta"} <= set(told)
    said = capsys.readouterr().out
    assert "mu and beta0 of two lines are no law of theirs: fitted e = 0.7" in said


def test_the_command_writes_the_report_and_the_tables(
    folder: Path, tmp_path: Path, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    out, csvs = tmp_path / "report.html", tmp_path / "tables"
    assert run(["report", str(folder), "--out", str(out), "--csv", str(csvs)]) == 0
    assert out.read_text(encoding="utf-8") == text
    assert {path.stem for path in csvs.iterdir()} == FILES
    assert capsys.readouterr().out.startswith("e = 0.7")


def test_a_place_that_cannot_be_written_is_said(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="cannot be written"):
        report(folder, out=tmp_path / "none" / "r.html", csv=None, config=None)


def test_a_campaign_that_is_not_there_ends_with_not_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(NotFoundError):
        report(Path("nylon"), out=tmp_path / "r.html", csv=None, config=None)
    with pytest.raises(AnalysisInputError):
        report(tmp_path / "a" / "b", out=tmp_path / "r.html", csv=None, config=None)
