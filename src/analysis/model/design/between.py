"""Shots that tell one effect from another, and how many of them it takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.effects.effect import Effect
from analysis.launch.result import LaunchFit
from analysis.model.design.candidates import Candidates, Setting, candidates
from analysis.model.design.choice import chosen, fewest_even
from analysis.model.design.duel import Duels, Truth, truth
from analysis.model.fit import Fit, fit_campaign
from analysis.model.leaders import ALIAS_WITHIN
from analysis.model.poses import PoseData

Floats = NDArray[np.float64]

PROBABILITY = 0.9
MOST_SHOTS, MOST_EVEN = 500, 5000
_ROUNDS = 3
_EVEN_GUESS = 20.0


@dataclass(frozen=True, slots=True)
class Repeated:
    """A setting and how many shots to fire there."""

    setting: Setting
    repeat: int


@dataclass(frozen=True, slots=True, eq=False)
class Telling:
    """Shots that tell one effect from another.

    Attributes
    ----------
    between
        Names of both; None is the base model.
    shots
        What to fire.
    probability
        That the right one is then named.
    without
        The same with the campaign's shots alone.
    even
        How many shots spread evenly over all settings do as much; None: more than 5000.
    enough
        Whether `probability` is what was asked for.
    """

    between: tuple[str | None, str | None]
    shots: tuple[Repeated, ...]
    probability: float
    without: float
    even: int | None
    enough: bool

    @property
    def count(self) -> int:
        """Shots in all."""
        return sum(one.repeat for one in self.shots)


def tell_apart(
    data: PoseData,
    base: Fit,
    launch: LaunchFit,
    pair: tuple[Effect | None, Effect | None],
    settings: Sequence[Setting],
    *,
    probability: float = PROBABILITY,
) -> Telling:
    """Choose the shots that tell one effect from another, beside what the campaign knows.

    Each is taken for true in turn, at the amplitude that the campaign gives it, and the other
    refitted to all shots (T-criterion). How likely either is true is what the campaign says. If
    the campaign should tell them by itself and does not, the next shots are to tell by themselves.

    Parameters
    ----------
    data, base, launch
        The campaign, the fit that either effect would join, and the fit of its launches.
    pair
        None: the base model. One of them is an effect.
    settings
        Those that the rig allows.

    Raises
    ------
    LaunchRefusedError
        No setting brings a collision in view.
    """
    drawn = candidates(data, base, launch, settings)
    truths, undecided = _truths(data, base, drawn, pair)
    counts = np.zeros(len(drawn.settings))
    duels = _duels(truths, counts)
    without = duels.probability(counts)
    if undecided and without >= probability:
        duels = Duels(tuple(duel.silenced() for duel in duels.duels))
    for _ in range(_ROUNDS):
        before, counts = counts, chosen(duels, duels.reaching(probability), MOST_SHOTS)
        if np.array_equal(before, counts):
            break
        duels = _duels(truths, counts, duels)
    counts = chosen(duels, duels.reaching(probability), MOST_SHOTS, start=counts)
    even = _duels(truths, np.full(len(counts), _EVEN_GUESS / len(counts)), duels)
    reached = duels.probability(counts)
    return Telling(
        between=(pair[0].name if pair[0] else None, pair[1].name if pair[1] else None),
        shots=repeated(drawn, counts),
        probability=reached,
        without=without,
        even=fewest_even(even.size, even.reaching(probability), MOST_EVEN),
        enough=reached >= probability,
    )


def best_fit(data: PoseData, base: Fit, effect: Effect | None) -> Fit:
    """Return the fit with an effect in its likeliest variant; without one, the base."""
    if effect is None:
        return base
    forms = (effect, *effect.variants)
    fits = [fit_campaign(data, base.theory.with_effect(form), base) for form in forms]
    return min(fits, key=lambda fit: fit.chi2)


def repeated(drawn: Candidates, counts: Floats) -> tuple[Repeated, ...]:
    """Return the settings that are fired at all, in their order."""
    return tuple(
        Repeated(setting, int(count))
        for setting, count in zip(drawn.settings, counts, strict=True)
        if count
    )


def _truths(
    data: PoseData, base: Fit, drawn: Candidates, pair: tuple[Effect | None, Effect | None]
) -> tuple[tuple[Truth, ...], bool]:
    """Return what may be true, and whether the campaign leaves it open which of two effects."""
    first, second = (best_fit(data, base, effect) for effect in pair)
    if pair[1] is None:
        return (truth(data, drawn, first, second, 1.0),), False
    if pair[0] is None:
        return (truth(data, drawn, second, first, 1.0),), False
    more = len(second.theory.names) - len(first.theory.names)
    ahead = (second.chi2 - first.chi2) / max(base.chi2_per_dof, 1.0)
    ahead += more * float(np.log(len(data.shots)))
    trust = float(1 / (1 + np.exp(-np.clip(ahead, -100, 100) / 2)))
    truths = (
        truth(data, drawn, first, second, trust),
        truth(data, drawn, second, first, 1 - trust),
    )
    return truths, bool(abs(ahead) < ALIAS_WITHIN)


def _duels(truths: Sequence[Truth], counts: Floats, start: Duels | None = None) -> Duels:
    """Refit the rivals about a design; what an earlier design did not count stays uncounted."""
    earlier = [None] * len(truths) if start is None else start.duels
    return Duels(
        tuple(
            replace(one.duel(counts, first), discounted=first.discounted if first else 0.0)
            for one, first in zip(truths, earlier, strict=True)
        )
    )
