"""A daemon that is killed again and again at random moments of its sweeps."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LASTS_AT_MOST_S = 500.0


@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    ("kills", "at_most_s"), [(7, 300.0), pytest.param(1000, 60.0, marks=pytest.mark.long)]
)
def test_no_step_is_fired_twice_and_no_shot_is_lost_however_the_daemon_dies(
    tmp_path: Path, kills: int, at_most_s: float
) -> None:
    report = tmp_path / "kill.json"
    done = subprocess.run(
        [
            *(sys.executable, "-m", "benchmarks.kill", "--out", report),
            *("--kills", f"{kills}", "--seconds", f"{at_most_s}"),
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
