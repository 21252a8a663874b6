"""The guide to Python, followed to the letter in a script without a guard."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.system.test_documentation import DOCS, PYTHON, ROOT, needs_shell, perform

GUIDE = DOCS / "how-to" / "use-from-python.md"
HIDDEN = "restitution-obliquity and torsional-friction"

pytestmark = pytest.mark.timeout(600)


@needs_shell
@pytest.mark.long
def test_the_guide_measures_fits_and_explains(tmp_path: Path) -> None:
    perform(GUIDE, tmp_path)
    script = tmp_path / "guide.py"
    script.write_text("".join(PYTHON.findall(GUIDE.read_text(encoding="utf-8"))))
    done = subprocess.run(
        [sys.executable, "-W", "error", str(script)],
        cwd=tmp_path,
        env={**os.environ, "RIGCTL_CACHE": str(tmp_path / "cache")},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "4 measured shots" in done.stdout
    assert f"the missing effects are {HIDDEN}" in done.stdout
    contact_spot = re.search(r"^0\.0008\d*\((\d+)\) m$", done.stdout, re.MULTILINE)
    assert contact_spot, done.stdout
    for picture in ("restitution", "ranking", "error-path", "structure"):
        assert (tmp_path / f"{picture}.png").stat().st_size > 10_000


def test_the_lines_of_the_readme_are_names_that_there_are() -> None:
    import rigctl

    [lines] = PYTHON.findall((ROOT / "README.md").read_text(encoding="utf-8"))
    assert len([line for line in lines.splitlines() if line]) <= 10
    kinds = {
        "rigctl": rigctl,
        "campaign": rigctl.Campaign,
        "shots": rigctl.Shots,
        "fit": rigctl.Fit,
    }
    calls = re.findall(r"\b(rigctl|campaign|shots|fit)\.(\w+)\(", lines)
    assert len(calls) == 8
    for owner, name in calls:
        assert callable(getattr(kinds.get(owner, rigctl), name)), f"{owner}.{name}"
