"""The guides to results and to other systems, run as their readers would."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.system.test_documentation import DOCS, needs_shell, perform

pytestmark = pytest.mark.long

REPORT = DOCS / "how-to" / "report-results.md"
OTHERS = DOCS / "how-to" / "other-systems.md"


@needs_shell
@pytest.mark.timeout(600)
def test_the_guide_to_the_report_writes_it_with_its_tables(tmp_path: Path) -> None:
    said = perform(REPORT, tmp_path)
    assert said.rstrip().splitlines()[-1].startswith("e = 0.7")
    assert (tmp_path / "report.html").read_text(encoding="utf-8").startswith("<!doctype html>")
    written = {path.name for path in (tmp_path / "tables").iterdir()}
    page = REPORT.read_text(encoding="utf-8")
    assert {name for name in written if f"`{name}`" not in page} == set()


@needs_shell
@pytest.mark.timeout(600)
def test_the_guide_to_other_systems_writes_both_forms(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    perform(OTHERS, tmp_path)
    page = OTHERS.read_text(encoding="utf-8")
    with h5py.File(tmp_path / "nylon.nxs") as file:
        groups = [name for name, item in file["entry"].items() if isinstance(item, h5py.Group)]
    assert {name for name in groups if f"`{name}`" not in page} == set()
    lines = (tmp_path / "nylon.jsonl").read_text().splitlines()
    assert [json.loads(line)[0] for line in (lines[0], lines[-1])] == ["start", "stop"]
