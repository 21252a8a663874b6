"""An error of images that moves places by no more than slow errors do is no finding."""

from dataclasses import replace
from functools import cache

import numpy as np

from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import fit_campaign
from analysis.model.rank.candidate import Candidate
from analysis.model.rank.leaders import refitted
from analysis.model.rank.ranking import rank
from analysis.model.verdict.words import doubts
from analysis.setup import SlowErrors
from simulators.challenge.nature import Nature
from tests.unit.analysis.model.design.at_settings import drawn_settings, fired
from tests.unit.analysis.model.reported import reported

NAME = "mass-offset"
EFFECTS = [effect for effect in CATALOGUE if effect.name in {NAME, "image-scale", "wind"}]
OFFSET_M = np.array([4e-5, -3e-5, 8e-5])


@cache
def wobbling() -> PoseData:
    """Return shots in which outlines stand off the centres that fly, turning with the spheres."""
    data = fired(drawn_settings(14, 5), Nature(), 5)
    return replace(data, position=data.position + data.rotation @ OFFSET_M)


def found(shared_m: float) -> tuple[Candidate, list[str]]:
    data = replace(wobbling(), slow=SlowErrors(shared_m=shared_m))
    fit = fit_campaign(data)
    ranking = rank(data, fit, EFFECTS)
    candidate = next(c for c in ranking.candidates if c.effect.name == NAME)
    return candidate, [leader.name for leader in refitted(data, fit, ranking, 0.03)]


def test_an_offset_that_moves_places_by_more_than_slow_errors_is_found() -> None:
    candidate, leaders = found(1e-6)
    assert not candidate.of_measurement
    assert candidate.p_familywise < 0.01
    assert leaders[0] == NAME


def test_the_same_offset_is_the_images_own_where_their_slow_errors_are_as_large() -> None:
    candidate, leaders = found(2e-5)
    assert candidate.of_measurement
    assert candidate.p_familywise < 0.01
    assert NAME not in leaders


def test_what_is_moved_holds_at_least_what_lines_through_the_flights_leave() -> None:
    """Bent paths: R(t) c less the straight line on either side of the contact.

    The law of contact adds what it says of the lines.
    """
    data = wobbling()
    seen = data.rotation @ OFFSET_M
    half = data.times_s.shape[1] // 2
    left = []
    for side in (slice(0, half), slice(half, None)):
        tau = data.times_s[0, side] - data.times_s[0, side].mean()
        path = seen[:, side] - seen[:, side].mean(axis=1, keepdims=True)
        slope = np.einsum("t,stkx->skx", tau, path) / (tau @ tau)
        left.append(path - tau[:, None, None] * slope[:, None])
    bent = float(np.sqrt(np.mean(np.concatenate(left, axis=1) ** 2)))
    moved = found(1e-6)[0].moved_m
    assert moved is not None
    assert bent < moved < 4 * bent


def test_effects_of_the_law_and_the_air_are_not_the_images_own() -> None:
    data = replace(wobbling(), slow=SlowErrors(shared_m=1e-3))
    ranking = rank(data, fit_campaign(data), EFFECTS)
    assert {c.effect.name for c in ranking.candidates if c.of_measurement} <= {NAME}


def test_what_is_taken_for_the_images_own_stands_below_the_verdict() -> None:
    candidate = {
        "effect": NAME,
        "of_measurement": True,
        "moved_m": 7.6e-7,
        "p_familywise": 0.001,
        "promised_fall": 28.3,
        "plausible": True,
        **{"score": 5.3, "p_value": 1e-7, "amplitude": 1e-5, "sigma": 2e-6, "unit": "m"},
        "plausible_range": [-1e-4, 1e-4],
    }
    (sentence,) = doubts(reported(candidates=[candidate]))
    assert sentence.startswith("mass-offset by itself")
    assert "0.8 um" in sentence
    candidate["of_measurement"] = False
    assert doubts(reported(candidates=[candidate])) == []
