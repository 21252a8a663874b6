"""Stops under load, and the daemon's end, on a laboratory and a daemon of their own processes."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.long
@pytest.mark.timeout(600)
def test_no_stop_is_lost_under_any_load_and_the_power_goes_off_when_the_daemon_dies(
    tmp_path: Path,
) -> None:
    out = tmp_path / "stop.json"
    words = [sys.executable, "-m", "benchmarks.stop", "--times", "10", "--kills", "2"]
    done = subprocess.run(
        [*words, "--out", out], cwd=ROOT, capture_output=True, text=True, timeout=500, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    found = json.loads(out.read_text())
    assert {series["lost"] for series in found["stops"].values()} == {0}
    assert {end["stayed_on"] for end in found["dead_man"].values()} == {0}
    # By the box's own clock: its heartbeats are late at a time that no load of this machine moves.
    alone = [end for name, end in found["dead_man"].items() if name.endswith("the box alone")]
    assert len(alone) == 2
    assert max(taken for end in alone for taken in end["to_off_s"]) < 1.0
