"""The house: rooms small enough to look through, and a map that leads to what it names."""

from __future__ import annotations

import re
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
