"""`rigctl demo` as a user runs it: from firing to the opened seal."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

ENDS_WITHIN_S = 560.0
SHOTS = 10

pytestmark = [pytest.mark.long, pytest.mark.timeout(600)]


def test_the_demonstration_finds_what_the_simulated_rig_hides(tmp_path: Path) -> None:
    command = [sys.executable, "-W", "error", "-c", "from rigctl.cli import main; main()", "demo"]
    done = subprocess.run(
        [*command, "--out", str(tmp_path)],
        capture_output=True,
        text=True,
        timeout=ENDS_WITHIN_S,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    said = done.stdout
    lines = " ".join(said.split())
    # The contact that lasts may be worth less than one more name: each run scatters otherwise.
    answered = re.search(r"right: answered (.+?); the truth is (.+?) hidden:", lines)
    assert answered is not None
    named = answered[1].split(", ")
    assert set(named) | {"lasting-contact"} == {"torsional-friction", "lasting-contact"}
    assert "torsional-friction" in named
    truth = "torsional-friction, on top of lasting-contact, which this world always has"
    assert answered[2] == truth
    committed = said.index(f"Committed: {named[0]}")
    assert committed < said.index("right:") < said.index("hidden:")
    errors = [
        float(line.split()[-1])
        for line in said.partition("Add, and see the error fall")[2].splitlines()[2:4]
    ]
    assert errors[1] < 0.95 * errors[0]
    for picture in ("shot.png", "error-path.png"):
        assert (tmp_path / picture).stat().st_size > 10_000
    fires = (tmp_path / "demo/laboratory/truth/fires.jsonl").read_text().splitlines()
    assert [json.loads(line)["shot"] for line in fires] == list(range(1, SHOTS + 1))
