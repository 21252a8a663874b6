"""What the daemon loads before it answers: nothing that only the model or the analysis needs."""

from __future__ import annotations

import json
import subprocess
import sys

LATER = {"scipy.stats", "scipy.optimize", "numba", "matplotlib", "analysis.shot", "distributed"}


def test_the_daemon_starts_without_the_analysis_and_the_model() -> None:
    ask = "import json, sys, rigctl.cli.rig.serve; print(json.dumps(sorted(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", ask], capture_output=True, text=True, timeout=60, check=True
    )
    assert LATER & set(json.loads(done.stdout)) == set()
