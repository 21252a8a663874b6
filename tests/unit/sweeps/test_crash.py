"""A daemon that dies at any point of a step: what is known of it afterwards, and what goes on."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from bench import Bench, paused
from points import POINTS

from rigctl.errors import RefusedError
from rigctl.store import SweepState

ONE = "20260131-s0001"


@pytest.fixture(scope="module")
def killed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("killed")
    script = Path(__file__).parent / "killed_sweep.py"
    done = subprocess.run(
        [sys.executable, script, folder], capture_output=True, text=True, timeout=230, check=False
    )
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.parametrize("point", POINTS)
def test_a_killed_sweep_offers_to_go_on_and_never_fires_what_may_have_fired(
    killed: Path, point: str
) -> None:
    state, fires = POINTS[point]
    folder = killed / str(list(POINTS).index(point))
    fired_before = (folder / "fires").read_text().count("fired")
    bench = Bench(folder / "data")
    assert [sweep.id for sweep in bench.offered] == [ONE]
    assert "the daemon ended" in paused(bench.runner.status(ONE))
    assert bench.states(ONE) == ["stored", state, "waiting"]
    with pytest.raises(RefusedError, match="unknown_outcome" if state == "unknown" else "estop"):
        bench.runner.resume(ONE, "anna")
    bench.lab.rig.release("anna", "looked at the tubes")
    assert bench.fires == 0
    done = bench.resume(ONE)
    assert done.record.state is SweepState.COMPLETED
    final = "stored" if state == "not_fired" else state
    assert bench.states(ONE) == ["stored", final, "stored"]
    assert fired_before + bench.fires == fires
    stored = [shot.id for shot in bench.lab.store.shots() if shot.outcome == "stored"]
    assert all(bench.lab.store.folders.is_whole(shot) for shot in stored)
    bench.close()


def test_a_daemon_that_ended_in_order_offers_its_sweep_too(bench: Bench) -> None:
    bench.at_fire(1, lambda: bench.runner.pause(ONE, "anna"))
    bench.run()
    bench.start_again()
    assert [sweep.id for sweep in bench.offered] == [ONE]
    assert paused(bench.runner.status(ONE)) == "paused by anna"
    assert bench.resume(ONE).record.state is SweepState.COMPLETED
