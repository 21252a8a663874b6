"""The house: rooms small enough to look through, and a map that leads to what it names."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
MOST_FILES = 22
FOLDERS = sorted({path.parent for path in (ROOT / "src").rglob("*.py")})


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: str(folder.relative_to(ROOT)))
def test_no_folder_has_more_files_than_can_be_looked_through(folder: Path) -> None:
    assert len(list(folder.glob("*.py"))) <= MOST_FILES


def test_every_place_of_the_map_is_there() -> None:
    rows = re.findall(r"^\|[^|]+\|(.+)\|$", (ROOT / "CONTRIBUTING.md").read_text("utf-8"), re.M)
    named = [place for row in rows for place in re.findall(r"`((?:analysis|rigctl)/[^`]+)`", row)]
    assert len(named) > 10
    for place in named:
        before, _, rest = place.partition("{")
        rooms = rest.rstrip("}").split(",") if rest else [""]
        for room in rooms:
            assert (ROOT / "src" / f"{before}{room}").exists(), place


def test_imported_names_that_do_not_exist_are_found_with_their_lines(
    tmp_path: Path,
) -> None:
    for folder in ("src/analysis", "benchmarks", "docs"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "src/analysis/shot.py").write_text("try:\n    HERE = 1\nfinally:\n    pass\n")
    (tmp_path / "benchmarks/late.py").write_text(
        "from analysis.shot import HERE, gone\n\ndef run():\n    import analysis.vanished\n"
        'NAMED = ("analysis.shot:HERE", "analysis.shot:never", "analysis")\n'
    )
    (tmp_path / "docs/page.md").write_text(
        "Run `python -m benchmarks.late` or `python -m benchmarks.early`.\n"
        "```python\nfrom analysis import shot, film\n```\n"
    )
    missing = runpy.run_path(str(ROOT / "packaging/imports.py"))["missing"]
    assert missing(tmp_path) == [
        "benchmarks/late.py:1: analysis.shot.gone does not exist",
        "benchmarks/late.py:4: analysis.vanished does not exist",
        "benchmarks/late.py:5: analysis.shot.never does not exist",
        "docs/page.md: analysis.film does not exist",
        "docs/page.md: benchmarks.early does not exist",
    ]


@pytest.mark.parametrize(
    ("last", "expected"),
    [
        ("from room import first", {"room.first", "room.second", "room.third"}),
        ("def run():\n    from .first import run", {"room.first", "room.second", "room.third"}),
        ("if TYPE_CHECKING:\n    from room.first import run", set()),
        ("NAMED = 'room.first:run'", set()),
    ],
)
def test_files_that_import_each_other_in_a_circle_are_named(
    tmp_path: Path, last: str, expected: set[str]
) -> None:
    room = tmp_path / "src" / "room"
    room.mkdir(parents=True)
    (room / "__init__.py").touch()
    (room / "first.py").write_text("import room.second\n")
    (room / "second.py").write_text("from room.third import *\n")
    (room / "third.py").write_text(f"{last}\n")
    circle = runpy.run_path(str(ROOT / "packaging/imports.py"))["circle"]
    assert set(circle(tmp_path)) == expected
