"""What a campaign hides: drawn by chance, and written as its label."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from simulators.challenge.effects import FORMED, HIDDEN, STRENGTHS, Hidden
from simulators.options import IN_CONTACT

_NOTHING, _OUTSIDE, _TWO, _ONE = 0.1, 0.15, 0.2, 0.55
"""How often nothing is hidden, something outside every catalogue, two effects, one."""
_A_LAW, _LAWS_FROM = 1 / 6, 0.3
"""How often, whatever else was drawn, a law that no catalogue holds is hidden in its place; and
where in a draw from 0 to 1 that share begins."""

Amplitudes = Mapping[str, float]
"""Amplitude of each hidden effect by name, in the effect's own unit."""


def draw_label(rng: np.random.Generator, strength: str) -> Amplitudes:
    """Draw what to hide; effects that this strength makes invisible are left out.

    Raises
    ------
    KeyError
        No strength has this name.
    """
    factor = STRENGTHS[strength]
    drawn = [effect for effect in HIDDEN.values() if effect.name not in FORMED]
    able = [effect for effect in drawn if factor == 1.0 or not effect.faint]
    known = [effect for effect in able if effect.known]
    kind = rng.choice(4, p=(_NOTHING, _OUTSIDE, _TWO, _ONE))
    if kind == 0:
        chosen = []
    elif kind == 1:
        chosen = [_one(rng, [effect for effect in able if not effect.known])]
    else:
        chosen = [_one(rng, known)]
        if kind == 2:
            others = [effect for effect in known if effect.acts_on != chosen[0].acts_on]
            chosen.append(_one(rng, others))
    amplitudes = {effect.name: factor * _signed(rng, effect) for effect in chosen}
    if _LAWS_FROM < rng.random() < _LAWS_FROM + _A_LAW:
        law = _one(rng, list(FORMED.values()))
        return {law.name: factor * _signed(rng, law)}
    return amplitudes


def draw_in_contact(rng: np.random.Generator, name: str | None = None) -> Amplitudes:
    """Draw one effect that acts in the contact, or the sign of the named one, at full strength."""
    effect = _one(rng, [HIDDEN[each] for each in ([name] if name else IN_CONTACT)])
    return {effect.name: _signed(rng, effect)}


def label_document(amplitudes: Amplitudes, world: Sequence[str] = ()) -> dict[str, Any]:
    """Return the label: effects, the right answer, and what else an answer may say.

    Parameters
    ----------
    world
        The catalogue's names of what the world has beside hard spheres, whatever is hidden.
    """
    hidden = [HIDDEN[name] for name in amplitudes]
    answer = [effect.name if effect.known else "unexplained" for effect in hidden]
    return {
        "answer": answer or ["none"],
        "effects": [
            {
                "effect": effect.name,
                "amplitude": amplitudes[effect.name],
                "unit": effect.unit,
                "meaning": effect.meaning,
                **({"law": list(effect.law)} if effect.law else {}),
            }
            for effect in hidden
        ],
        "like": {effect.name: list(effect.like) for effect in hidden if effect.like},
        "beside": [name for effect in hidden for name in effect.beside],
        "world": list(world),
    }


def _one(rng: np.random.Generator, effects: list[Hidden]) -> Hidden:
    return effects[int(rng.integers(len(effects)))]


def _signed(rng: np.random.Generator, effect: Hidden) -> float:
    negative = effect.either_sign and bool(rng.integers(2))
    return -effect.amplitude if negative else effect.amplitude
