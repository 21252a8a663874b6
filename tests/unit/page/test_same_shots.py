"""Before and after an effect the page compares the same shots, and says which came back."""

from __future__ import annotations

import json
from collections.abc import Sequence
from datetime import UTC, datetime
from types import SimpleNamespace
from typing import Any

import pytest

from rigctl.jobs import Job, JobState
from rigctl.page.model.state import ModelState
from rigctl.page.model.story.answers import came_back

AT = datetime(2026, 1, 1, tzinfo=UTC)
# Without drag, two shots lie off; the error that these bring is seen when they are in.
ANSWERS = {
    ((), ()): ([10, 14], 1.05),
    (("drag",), ("drag",)): ([], 0.99),
    ((), ("drag",)): ([], 1.12),
    (("wind",), ("wind",)): ([10, 14], 1.04),
}


class Answering:
    """A source whose jobs end when they are `told` to."""

    def __init__(self) -> None:
        self.jobs: dict[str, Job] = {}
        self.daemon = SimpleNamespace(jobs=SimpleNamespace(job=self.jobs.__getitem__))

    def ask(self, kind: str, effects: Sequence[str] = (), shots_of: Sequence[str] = ()) -> Job:
        assert kind == "picture"
        rejected, error = ANSWERS[tuple(effects), tuple(shots_of or effects)]
        result = json.dumps({"rejected": rejected, "prediction_error": error})
        for job in self.jobs.values():
            if job.result == result and job.state is not JobState.CANCELLED:
                return job
        name = f"{len(self.jobs)}"
        self.jobs[name] = Job(name, kind, "x", JobState.RUNNING, AT, result=result)
        return self.jobs[name]

    def told(self) -> int:
        """End what runs; return how many that were."""
        running = [job for job in self.jobs.values() if job.state is JobState.RUNNING]
        for job in running:
            done = Job(job.id, job.kind, "x", JobState.DONE, AT, result=job.result)
            self.jobs[job.id] = done
        return len(running)


@pytest.fixture
def source() -> Answering:
    return Answering()


@pytest.fixture
def state(source: Answering) -> ModelState:
    fake: Any = source
    state = ModelState(fake)
    state.take(())
    source.told()
    state.follow()
    return state


def test_an_effect_that_is_looked_at_is_compared_on_the_shots_that_fit_with_it(
    state: ModelState, source: Answering
) -> None:
    state.ask_trial("drag")
    source.told()
    state.follow()
    assert state.tried("drag") is None
    assert state.tries("drag")
    source.told()
    state.follow()
    before, after = state.tried("drag") or ({}, {})
    assert before["rejected"] == after["rejected"] == []
    assert state.trials() == {"drag": pytest.approx(0.99 / 1.12)}
    # What was compared first stays as it was found.
    assert [one["rejected"] for one in state.path()] == [[10, 14]]


def test_after_an_effect_was_added_every_stage_is_of_its_shots(
    state: ModelState, source: Answering
) -> None:
    state.take(("drag",))
    assert state.path() == [{"rejected": [10, 14], "prediction_error": 1.05}]
    source.told()
    state.follow()
    assert state.present is None
    assert source.told() == 1
    assert state.follow() == (True, False)
    assert [one["prediction_error"] for one in state.path()] == [1.12, 0.99]
    assert state.come_back() == [10, 14]
    assert state.is_of_the_same_shots
    state.take(())
    assert source.told() == 0
    assert state.present == {"rejected": [10, 14], "prediction_error": 1.05}
    # On a page that is loaded anew all of it is known at once.
    again = ModelState(state.source)
    again.take(("drag",))
    assert [one["prediction_error"] for one in again.path()] == [1.12, 0.99]


def test_of_the_same_shots_nothing_is_fitted_twice(state: ModelState, source: Answering) -> None:
    state.take(("wind",))
    source.told()
    state.follow()
    assert len(source.jobs) == 2
    assert len(state.path()) == 2
    assert state.come_back() == []


def test_a_comparison_that_was_cancelled_is_not_called_one_of_the_same_shots(
    state: ModelState, source: Answering
) -> None:
    state.ask_trial("drag")
    source.told()
    state.follow()
    (running,) = (job for job in source.jobs.values() if job.state is JobState.RUNNING)
    source.jobs[running.id] = Job(running.id, "picture", "x", JobState.CANCELLED, AT)
    state.follow()
    assert state.tried("drag") is not None
    assert state.trials() == {}
    state.take(("drag",))
    assert state.present is not None
    assert not state.is_of_the_same_shots
    assert "“After” alone has these" in came_back(state.come_back(), same=False)
