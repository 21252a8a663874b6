"""A step takes only the shot that its sweep fired, whatever keys others use."""

from __future__ import annotations

import hashlib
import secrets

import pytest
from bench import Bench, plan

GUESSED = "20260131-s0001/1/1"


def fire_beforehand(bench: Bench, key: str) -> str:
    """Fire what the first step is going to, by hand and under a key of choice."""
    settings = plan([1.0]).steps[0]
    token = bench.lab.rig.arm(settings, "eve").token
    body = hashlib.sha256(settings.model_dump_json().encode()).hexdigest()
    return bench.lab.rig.fire(token, key, body, campaign="nylon", actor="eve").id


def test_a_shot_fired_under_a_guessed_key_is_not_taken_for_the_steps(bench: Bench) -> None:
    before = fire_beforehand(bench, GUESSED)
    done = bench.run(plan([1.0]))
    (step,) = bench.steps(done.record.id)
    assert step.state == "stored"
    assert step.shot != before
    assert bench.lab.trigger.fired == [1, 2]


def test_a_key_that_somebody_used_all_the_same_fires_nothing_and_leaves_nothing_armed(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(secrets, "token_urlsafe", lambda size: "no longer a secret")
    before = fire_beforehand(bench, "no longer a secret")
    (step,) = bench.steps(bench.run(plan([1.0])).record.id)
    assert step.state == "not_fired"
    assert f"shot {before} of eve has the key of the step" in str(step.failure)
    assert bench.lab.trigger.fired == [1]
    assert (bench.lab.state, bench.lab.trigger.armed) == ("idle", None)
