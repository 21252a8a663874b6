"""Frames that are missing from a film, found in places whose law is known in closed form."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from analysis.balls.flight import lost
from analysis.balls.flight.fit import fit_flights
from analysis.balls.flight.flights import Flights, Observed
from analysis.balls.flight.lost import find_gap, unsure_e
from analysis.balls.gaps import Gap
from tests.unit.analysis.balls.parabolas import (
    BOUNCES,
    NOISE,
    RATE,
    SCALE,
    known,
    parabolas,
    start,
)


@pytest.mark.parametrize(
    ("first", "count", "stated"),
    [
        (40, 1, 1.0),
        pytest.param(100, 2, 1.0, marks=pytest.mark.long),
        pytest.param(30, 1, 0.5, marks=pytest.mark.long),
        pytest.param(30, 1, 2.0, marks=pytest.mark.long),
    ],
)
def test_frames_that_are_missing_are_found_whatever_diameter_is_stated(
    first: int, count: int, stated: float
) -> None:
    whole = parabolas(np.random.default_rng(10))
    kept = np.delete(np.arange(len(whole.frames)), np.arange(first, first + count))
    times = whole.times_s[: len(kept)]
    lacking = replace(whole.of(kept), frames=np.arange(len(kept)), times_s=times)
    begun = start()
    late = begun.times_s > first / RATE
    begun = replace(begun, times_s=begun.times_s - late * count / RATE)
    ball = known(diameter_m=0.04 * stated)
    flights = fit_flights(lacking, begun, ball)
    assert flights is not None
    assert find_gap(lacking, begun, ball, flights).gap == Gap(first, count)


def test_once_all_places_lie_on_flights_no_other_gap_is_tried(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    whole = parabolas(np.random.default_rng(10))
    kept = np.delete(np.arange(len(whole.frames)), [40])
    times = whole.times_s[: len(kept)]
    lacking = replace(whole.of(kept), frames=np.arange(len(kept)), times_s=times)
    begun = start()
    begun = replace(begun, times_s=begun.times_s - 1 / RATE)
    flights = fit_flights(lacking, begun, known())
    assert flights is not None
    tried: list[float] = []

    def counted(observed: Observed, *others: Any, **more: Any) -> Flights | None:
        found = fit_flights(observed, *others, **more)
        assert found is not None
        tried.append(float(np.abs(found.residuals).max()))
        return found

    monkeypatch.setattr(lost, "fit_flights", counted)
    assert find_gap(lacking, begun, known(), flights).gap == Gap(40, 1)
    *others, last = tried
    assert last < 5 * NOISE < min(others, default=1.0)


def test_a_film_of_no_one_rate_is_fitted_a_stated_number_of_times(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """At half its rate from the middle of a flight on, its times fit with no gap."""
    whole = parabolas(np.random.default_rng(10))
    count = len(whole.frames)
    shown = np.concatenate([np.arange(90), np.arange(90, count, 2)])
    times = whole.times_s[: len(shown)]
    uneven = replace(whole.of(shown), frames=np.arange(len(shown)), times_s=times)
    begun = start()
    begun = replace(begun, times_s=np.interp(begun.times_s * RATE, shown, times))
    flights = fit_flights(uneven, begun, known())
    assert flights is not None
    tried: list[Observed] = []

    def counted(observed: Observed, *others: Any, **more: Any) -> Flights | None:
        tried.append(observed)
        return fit_flights(observed, *others, **more)

    monkeypatch.setattr(lost, "fit_flights", counted)
    find_gap(uneven, begun, known(), flights)
    assert len(tried) <= 6


def test_no_frames_are_missing_from_a_film_that_is_whole() -> None:
    whole = parabolas(np.random.default_rng(11))
    flights = fit_flights(whole, start(), known())
    assert flights is not None
    found = find_gap(whole, start(), known(), flights)
    assert found.gap is None
    assert found.unsure_e == pytest.approx(0.0)
    assert unsure_e(flights) == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("seed", "noise", "bounce", "beside", "steps"),
    [(58, 0.6, 0, 1, 1.18), (30, 0.3, 1, 1, 1.02), (5, 0.3, 1, -1, 1.11), (59, 0.6, 0, 1, 1.89)],
)
def test_one_place_that_lies_off_beside_a_bounce_does_not_say_that_frames_are_missing(
    seed: int, noise: float, bounce: int, beside: int, steps: float
) -> None:
    """By about as much as the ball goes on in a frame or two, as over a shadow."""
    whole = parabolas(np.random.default_rng(seed), noise=noise)
    places, (time, _, up) = whole.places.copy(), BOUNCES[bounce]
    places[int(np.searchsorted(whole.times_s, time)) + beside, 0] += steps * SCALE * up / RATE
    off = replace(whole, places=places, sigmas=np.full(places.shape, noise))
    flights = fit_flights(off, start(), known())
    assert flights is not None
    assert find_gap(off, start(), known(), flights).gap is None


def test_a_fit_of_other_bounces_does_not_say_that_frames_are_missing_from_these() -> None:
    whole = parabolas(np.random.default_rng(12))
    between = 0.5 * (BOUNCES[0][0] + BOUNCES[1][0])
    early, late = whole.of(whole.times_s < between), whole.of(whole.times_s >= between)
    flights = fit_flights(early, start(BOUNCES[:1]), known())
    assert flights is not None
    begun = start(BOUNCES[1:])
    begun = replace(begun, times_s=begun.times_s + 0.01)
    assert find_gap(late, begun, known(), flights).gap is None
