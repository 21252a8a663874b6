"""The verdict on campaigns of the simulators, whose physics is not that of the model.

A small part of `python -m benchmarks.discovery`, with the whole catalogue looked at.
"""

from __future__ import annotations

import pytest

from benchmarks.discovery.strength import strength
from benchmarks.discovery.trial import Task, judge

pytestmark = pytest.mark.long

SHOTS = 40
FOUND = (
    "restitution-drift",
    "friction-drift",
    "torsional-friction",
    "magnus-lift",
    "image-scale",
    "frame-rate",
    "pixel-aspect",
    "mirror-angle",
)


def test_a_campaign_that_hides_nothing_is_rarely_given_a_name() -> None:
    trials = [judge(Task(seed=800 + k, shots=SHOTS)) for k in range(8)]
    # Each claims with a chance of 0.03, alarms with 0.01: three or more of eight in 0.3 per cent.
    assert sum(trial.word != "none" for trial in trials) <= 2


def test_what_is_six_standard_errors_large_is_found_and_rightly_named() -> None:
    trials = [
        judge(Task(seed=850 + k, shots=SHOTS, wanted={name: 6.0})) for k, name in enumerate(FOUND)
    ]
    # Each is lost with a chance of 0.003 and wrongly named with 0.02.
    right = [t.holds(name) for t, name in zip(trials, FOUND, strict=True)]
    assert sum(right) >= len(FOUND) - 1


def test_a_silent_campaign_without_an_effect_has_no_strength() -> None:
    assert strength({}, 840, 12) == pytest.approx(0.0, abs=0.01)
    assert strength({"image-scale": 1e-3}, 840, 12) > 5
