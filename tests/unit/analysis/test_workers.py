"""Processes beside a script: they answer, they say why they cannot, and need nothing of it."""

from __future__ import annotations

import math
import operator
import os
import subprocess
import sys
from pathlib import Path

import pytest

from analysis.workers import WorkerDiedError, Workers
from simulators.world import write_campaign

UNGUARDED = """
import sys
from pathlib import Path
from analysis.campaign import analyse_campaign, read_campaign
from analysis.shot import AnalysisOptions
print("begun")
campaign = read_campaign(Path(sys.argv[1]))
for job, shot, _ in analyse_campaign(campaign, AnalysisOptions(method="thesis"), workers=2):
    print(job.shot, type(shot).__name__)
"""


def test_several_processes_answer_in_the_order_of_the_questions() -> None:
    with Workers(2) as workers:
        futures = [workers.submit(math.factorial, n) for n in range(12)]
        assert [future.result() for future in futures] == [math.factorial(n) for n in range(12)]
        elsewhere = {workers.submit(os.getpid).result() for _ in range(4)}
    assert elsewhere
    assert os.getpid() not in elsewhere


@pytest.mark.parametrize(("stated", "expected"), [(None, "1"), ("2", "2")])
def test_a_process_has_one_thread_of_linear_algebra_unless_more_are_stated(
    monkeypatch: pytest.MonkeyPatch, stated: str | None, expected: str
) -> None:
    monkeypatch.delenv("OPENBLAS_NUM_THREADS")
    if stated is not None:
        monkeypatch.setenv("OPENBLAS_NUM_THREADS", stated)
    with Workers(1) as workers:
        assert workers.submit(os.getenv, "OPENBLAS_NUM_THREADS").result() == expected


def test_an_error_is_raised_where_the_answer_is_asked_for() -> None:
    with Workers(1) as workers:
        failed, fine = workers.submit(operator.truediv, 1, 0), workers.submit(operator.add, 1, 2)
        with pytest.raises(ZeroDivisionError, match="division by zero"):
            failed.result()
        assert fine.result() == 3


def test_what_a_function_prints_is_no_answer(capfd: pytest.CaptureFixture[str]) -> None:
    with Workers(1) as workers:
        assert workers.submit(print, "words").result() is None
        assert workers.submit(os.write, 1, b"raw words").result() == 9
    printed = capfd.readouterr()
    assert printed.out == ""
    assert "raw words" in printed.err


def test_a_process_that_dies_is_named_and_the_next_question_has_another() -> None:
    with Workers(1) as workers:
        with pytest.raises(WorkerDiedError, match="status 9"):
            workers.submit(os._exit, 9).result()
        assert workers.submit(math.sqrt, 4.0).result() == 2.0


def test_no_process_is_left_when_the_block_ends() -> None:
    with Workers(1) as workers:
        process = workers.submit(os.getpid).result()
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)


def test_a_script_without_a_guard_measures_a_folder_of_frames(tmp_path: Path) -> None:
    write_campaign(tmp_path / "nylon", [40.0, 50.0, 60.0], [6.0, 8.0, 10.0], 3, frames=16)
    script = tmp_path / "measure.py"
    script.write_text(UNGUARDED)
    done = subprocess.run(
        [sys.executable, str(script), str(tmp_path / "nylon")],
        capture_output=True,
        text=True,
        timeout=200,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    # A second "begun" would be a process that ran the script again.
    assert done.stdout.splitlines() == ["begun", *(f"{k} MeasuredShot" for k in (1, 2, 3))]
