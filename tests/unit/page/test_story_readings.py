"""What the slider says of a size, against the law that the effect itself wraps round a contact."""

from __future__ import annotations

import re

import numpy as np
import pytest

from analysis.collision.operator import Body, Encounter, Outcome, States
from analysis.effects.effect import ContactEffect
from rigctl.model.known_effects import ALL_EFFECTS
from rigctl.page.model.story.answers import learnt
from rigctl.page.model.story.lead import FAST, READINGS, SLOW, sentence_of

EFFECTS = {effect.name: effect for effect in ALL_EFFECTS}
BOUNCE = 0.74


def bounces(effect: str, amplitude: float) -> list[float]:
    """Return e at the two speeds that are read, from the effect's own law."""
    speeds = np.array([SLOW, FAST])
    still, body = np.zeros((2, 3)), Body.sphere(0.0254, 1150.0, 0.4)
    coming = np.column_stack([still[:, 0], -speeds, still[:, 0]])
    before = States(still, coming, still, still)
    normal = np.tile([0.0, 1.0, 0.0], (2, 1))
    seen: list[Encounter] = []

    class SeenError(Exception):
        """The law has changed the contact: no need to go through it."""

    def operator(encounter: Encounter) -> Outcome:
        seen.append(encounter)
        raise SeenError

    whole = np.full(2, BOUNCE)
    contact = Encounter(before, normal, (body, body), whole, 0.1 * whole, 0.5 * whole, {})
    law = EFFECTS[effect]
    assert isinstance(law, ContactEffect)
    with pytest.raises(SeenError):
        law.wrap(operator, np.array([amplitude]))(contact)
    return [float(value) for value in seen[0].e]


@pytest.mark.parametrize(
    ("effect", "amplitude"),
    [
        ("restitution-plastic", 0.08),
        ("restitution-yield-knee", 0.1),
        pytest.param("restitution-viscoelastic", 0.05, marks=pytest.mark.long),
    ],
)
def test_the_bounce_that_is_said_is_that_of_the_law(effect: str, amplitude: float) -> None:
    said = sentence_of(effect, amplitude, BOUNCE)
    slow, fast = map(float, re.findall(r"0\.\d\d", said))
    assert [slow, fast] == pytest.approx(bounces(effect, amplitude), abs=0.011)


def test_a_size_that_is_said_is_in_the_unit_of_the_sentence() -> None:
    assert sentence_of("velocity-offset", -0.02, BOUNCE) == "Every rebound is 20 mm/s slower."
    assert sentence_of("mirror-angle", 0.01, BOUNCE).startswith("The mirror stands at 45.57°")
    assert sentence_of("lasting-contact", 1.9e-4, BOUNCE) == "A contact at 1 m/s lasts 0.19 ms."


@pytest.mark.parametrize("effect", sorted(READINGS))
def test_a_sentence_names_no_slug_and_no_power_of_ten(effect: str) -> None:
    assert effect in EFFECTS
    for share in (-1.0, 0.0, 0.3, 1.0):
        said = sentence_of(effect, share * EFFECTS[effect].parameters[0].plausible[1], BOUNCE)
        assert said.endswith(".")
        assert not re.search(r"\de[-+]?\d", said)
        assert "-" not in said.replace("head-on", "")


def test_of_an_effect_of_ones_own_nothing_is_said() -> None:
    assert sentence_of("restitution-warmth", 0.1, BOUNCE) == ""


def test_what_was_found_is_told_as_what_it_does_and_what_speaks_for_it() -> None:
    spring = EFFECTS["lasting-contact"].parameters[0]
    effect = {
        "effect": "lasting-contact",
        "title": "",
        "parameters": [{"symbol": spring.symbol, "unit": spring.unit, "meaning": spring.meaning}],
    }
    row = {"channel": "common spin n", "covariate": "ln v_s/v_n"}
    before = {"prediction_error": 18.8, "parameters": {}, "findings": []}
    cell = {**row, "deviation": -33.2, "p_familywise": 1e-9}
    value = {"value": 1.892e-4, "sigma": 8.4e-7}
    after = {
        "prediction_error": 0.995,
        "parameters": {f"lasting-contact.{spring.symbol}": value},
        "findings": [{**row, "deviation": 1.1, "p_familywise": 0.9}],
    }
    mechanism, evidence = learnt(effect, before, after, (cell, {}, {}))
    assert mechanism.startswith("The spheres are pressed together for 0.1 to 0.2 ms")
    assert mechanism.endswith("a contact at 1 m/s lasts 0.19 ms (t = 0.18920 ± 0.00084 ms).")
    assert "falls from 18.8 to 0.995 times the noise" in evidence
    assert "by 33 standard deviations, with it no more than by chance" in evidence
    left = {**after, "findings": [{**row, "deviation": 12.0, "p_familywise": 1e-6}]}
    assert learnt(effect, before, left, (cell, {}, {}))[1].endswith("deviations, with it by 12.")
    assert "standard deviations" not in learnt(effect, before, after, None)[1]
    # Of a small effect, which no cell shows, its size speaks.
    small = {**before, "prediction_error": 0.996}
    evidence = learnt(effect, small, after, None)[1]
    assert "too little to tell by this error alone; its size is 225 standard errors" in evidence
