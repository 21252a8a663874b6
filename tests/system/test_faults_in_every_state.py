"""A part of the generated plan of faults, and some shots in a row; the benchmarks run the whole."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.faults import PASSED, plan
from benchmarks.soak import Size, at_rest

ROOT = Path(__file__).parents[2]


def run(module: str, tmp_path: Path, *words: str) -> dict[str, object]:
    out = tmp_path / "out.json"
    done = subprocess.run(
        [sys.executable, "-m", f"benchmarks.{module}", *words, "--out", out],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=900,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return dict(json.loads(out.read_text()))


@pytest.mark.parametrize("most", [12, pytest.param(80, marks=pytest.mark.long)])
@pytest.mark.timeout(1000)
def test_faults_drawn_from_the_plan_end_in_a_named_error_and_a_safe_state(
    tmp_path: Path, most: int
) -> None:
    found = run("faults", tmp_path, "--most", str(most), "--seed", "7")
    # Each has struck: a state that a shot passes only when something fails is provoked.
    assert (found["tried"], found["struck"], found["failed"]) == (most, most, [])


@pytest.mark.long
@pytest.mark.timeout(1000)
def test_a_worker_that_is_killed_in_any_state_refuses_its_shot_alone_and_by_name(
    tmp_path: Path,
) -> None:
    found = run("faults", tmp_path, "--part", "worker")
    assert (found["tried"], found["struck"], found["failed"]) == (len(PASSED), len(PASSED), [])


def test_the_plan_has_every_fault_in_every_state_that_a_shot_may_pass() -> None:
    parts = {"trigger", "regulator", "slide", "cut-off", "recorder", "relay"}
    by_state: dict[str, set[tuple[str, str]]] = {}
    for fault in plan():
        by_state.setdefault(fault.state, set()).add((fault.part, fault.kind))
    assert set(by_state) == set(PASSED)
    (kinds,) = {frozenset(kinds) for kinds in by_state.values()}
    assert {part for part, _ in kinds} == parts | {"disk", "catalogue", "clock", "worker"}
    assert ("worker", "killed") in kinds


@pytest.mark.long
@pytest.mark.timeout(1000)
def test_five_hundred_shots_in_a_row_are_all_stored_in_a_process_that_does_not_grow(
    tmp_path: Path,
) -> None:
    found = run("soak", tmp_path, "--shots", "500")
    assert found["failed"] == []
    assert found["fires"] == found["shots"] >= 500


@pytest.mark.parametrize(("mib_per_shot", "rests"), [(0.001, True), (0.1, False)])
def test_a_process_that_grows_with_its_shots_is_never_at_rest(
    mib_per_shot: float, rests: bool
) -> None:
    sizes = [Size(shots, 250 + mib_per_shot * shots, 60, 12) for shots in range(300, 1001, 50)]
    assert all(at_rest(sizes[: k + 1], 200) is rests for k in range(4, len(sizes)))
    more = [Size(each.shots, 250.0, 60 + k, 12) for k, each in enumerate(sizes)]
    assert not at_rest(more, 200)
