"""A daemon that is killed again and again at random moments of its sweeps."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LASTS_AT_MOST_S = 500.0


@pytest.mark.long
@pytest.mark.timeout(600)
def test_no_step_is_fired_twice_and_no_shot_is_lost_however_the_daemon_dies(
    tmp_path: Path,
) -> None:
    report = tmp_path / "kill.json"
    done = subprocess.run(
        [
            *(sys.executable, "-m", "benchmarks.kill", "--out", report),
            *("--kills", "1000", "--seconds", "60"),
        ],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=LASTS_AT_MOST_S,
        check=False,
    )
    assert report.exists(), done.stderr
    found = json.loads(report.read_text())
    assert found["sound"], done.stdout
    assert found["kills"] >= 5
    assert found["shots"] >= found["acknowledged"] > 0
    assert found["certain"] <= found["fires"] <= found["possible"]
