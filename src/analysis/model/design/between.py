"""Shots that tell one effect from another, and how many of them it takes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import ContactLaw, Effect
from analysis.launch.result import LaunchFit
from analysis.model.data.poses import PoseData
from analysis.model.design.candidates import FINE, Candidates, Setting, candidates
from analysis.model.design.choice import chosen, fewest_even
from analysis.model.design.duel import Belief, Duels, truth
from analysis.model.design.misfit import require_one_that_fits
from analysis.model.fitting.adding import ALIAS_WITHIN, added
from analysis.model.fitting.fit import Fit

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
    each, gain
        The same where the first and where the second of them is true, and by how much chi-squared
        comes to prefer it with the shots, on average, ln(shots) counted for each parameter. None
        against the base model.
    without
        That the one is right which the campaign's shots alone prefer.
    even
        How many shots spread evenly over all settings do as much; None: more than 5000.
    enough
        Whether `probability` is what was asked for.
    """

    between: tuple[str | None, str | None]
    shots: tuple[Repeated, ...]
    probability: float
    each: tuple[float, float] | None
    gain: tuple[float, float] | None
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
    MisfitError
        Neither fits the campaign: what is missing decides between them, not what they differ by.
    LaunchRefusedError
        No setting brings a collision in view.
    """
    contest = _contest(data, base, pair)
    coarse = candidates(data, base, launch, settings)
    start = contest.duels(coarse, np.zeros(len(coarse.settings)))
    without = start.probability(np.zeros(start.size))
    if contest.undecided and without >= probability:
        contest = contest.abreast()
    rough, counts = _designed(contest, coarse, probability)
    even = contest.duels(coarse, np.full(rough.size, _EVEN_GUESS / rough.size), rough)
    drawn, duels = coarse, rough
    if used := [one.setting for one in repeated(coarse, counts)]:
        drawn = candidates(data, base, launch, used, FINE)
        duels, counts = _designed(contest, drawn, probability)
    reached = duels.probability(counts)
    leads = [duel.leads for duel in duels.duels if duel.leads is not None]
    return Telling(
        between=(pair[0].name if pair[0] else None, pair[1].name if pair[1] else None),
        shots=repeated(drawn, counts),
        probability=reached,
        each=_either(float((lead.after(counts) > 0).mean()) for lead in leads),
        gain=_either(float(lead.after(counts).mean()) - lead.ahead for lead in leads),
        without=without,
        even=fewest_even(even.size, even.reaching(probability), MOST_EVEN),
        enough=reached >= probability,
    )


def best_fit(data: PoseData, base: Fit, effect: Effect | None) -> Fit:
    """Return the fit with an effect in its likeliest variant; without one, the base."""
    if effect is None:
        return base
    forms = (effect,) if isinstance(effect, ContactLaw) else (effect, *effect.variants)
    return min((added(data, base, form)[1] for form in forms), key=lambda fit: fit.chi2)


def repeated(drawn: Candidates, counts: Floats) -> tuple[Repeated, ...]:
    """Return the settings that are fired at all, in their order."""
    return tuple(
        Repeated(setting, int(count))
        for setting, count in zip(drawn.settings, counts, strict=True)
        if count
    )


def _either(numbers: Iterable[float]) -> tuple[float, float] | None:
    """Return what is foretold of either truth; there are none against the base model."""
    both = tuple(numbers)
    return (both[0], both[1]) if both else None


@dataclass(frozen=True, slots=True, eq=False)
class _Contest:
    """What may be true of a campaign: theories, their rivals, and how far each is believed."""

    data: PoseData
    pairs: tuple[tuple[Fit, Fit], ...]
    beliefs: tuple[Belief, ...]

    @property
    def undecided(self) -> bool:
        """Whether the campaign leaves it open which of two effects is true."""
        ahead = self.beliefs[0].ahead
        return ahead is not None and abs(ahead) < ALIAS_WITHIN

    def abreast(self) -> _Contest:
        """Return the contest as if neither effect were ahead."""
        return replace(self, beliefs=tuple(replace(b, ahead=0.0) for b in self.beliefs))

    def duels(self, drawn: Candidates, counts: Floats, start: Duels | None = None) -> Duels:
        """Take each for true, and refit its rival about a design."""
        earlier = [None] * len(self.pairs) if start is None else start.duels
        return Duels(
            tuple(
                truth(self.data, drawn, *pair, belief).duel(counts, first)
                for pair, belief, first in zip(self.pairs, self.beliefs, earlier, strict=True)
            )
        )


def _contest(data: PoseData, base: Fit, pair: tuple[Effect | None, Effect | None]) -> _Contest:
    """Fit both; how far either is believed follows from how well it fits."""
    first, second = (best_fit(data, base, effect) for effect in pair)
    require_one_that_fits(data, (first, second))
    if pair[0] is None or pair[1] is None:
        fits = (second, first) if pair[0] is None else (first, second)
        return _Contest(data, (fits,), (Belief(noise=max(fits[0].chi2_per_dof, 1.0)),))
    more = len(second.theory.names) - len(first.theory.names)
    noise = max(min(first.chi2_per_dof, second.chi2_per_dof), 1.0)
    ahead = (second.chi2 - first.chi2) / noise + more * float(np.log(len(data.shots)))
    trust = float(1 / (1 + np.exp(-np.clip(ahead, -100, 100) / 2)))
    beliefs = (Belief(trust, ahead, noise), Belief(1 - trust, -ahead, noise))
    return _Contest(data, ((first, second), (second, first)), beliefs)


def _designed(contest: _Contest, drawn: Candidates, probability: float) -> tuple[Duels, Floats]:
    """Choose shots, and refit the rivals about them in turn."""
    counts = np.zeros(len(drawn.settings))
    duels = contest.duels(drawn, counts)
    for _ in range(_ROUNDS):
        before, counts = counts, chosen(duels, duels.reaching(probability), MOST_SHOTS)
        if np.array_equal(before, counts):
            break
        duels = contest.duels(drawn, counts, duels)
    return duels, chosen(duels, duels.reaching(probability), MOST_SHOTS, start=counts)
