"""What is said of each effect that a campaign may lack, and of all of them together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import ContactLaw, Effect, FlightEffect
from analysis.model.rank.score_test import chance_of_falls

BEYOND_RANGE_SIGMAS = 2.0
STATED_WEIGHT = 10.0
"""Looks that a flight effect of stated size counts for, among the thirty of a catalogue."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """What a fit would gain by one effect, by its score.

    Attributes
    ----------
    effect
        The effect, in the variant with the largest expected drop.
    delta_chi2
        Expected drop of chi-squared, in units of the noise as it was found; none for an amplitude
        of the sign that nature does not have.
    freedom
        Directions in which it can be seen, at most one for each of its parameters.
    amplitudes, sigmas
        Of each of its parameters, in their units, shape (parameters,).
    p_value
        Of the fall by itself.
    p_familywise
        Share of campaigns with nothing missing in which some candidate looks as good as this, each
        by its weight.
    seen
        False where these shots hold no information on it; nothing else then has a meaning.
    carriers
        Numbers of the two shots that speak loudest for it.
    carried_share
        Share of the fall that is gone without these two.
    law
        The law that takes the operator's place in a refit, where the effect is its share.
    weight
        By which its chance may be larger than another's and count as much.
    moved_m, of_measurement
        Of a stated error of images: by how much at most it would move places, root mean square,
        and whether slow errors of the images do as much, so that it is no finding.
    """

    effect: Effect
    delta_chi2: float
    freedom: int
    amplitudes: Floats
    sigmas: Floats
    p_value: float
    p_familywise: float
    seen: bool
    carriers: tuple[int, ...]
    carried_share: float
    law: ContactLaw | None = None
    weight: float = 1.0
    moved_m: float | None = None
    of_measurement: bool = False

    @property
    def score(self) -> float:
        """Signed root of the fall for one parameter, the root for several."""
        if len(self.amplitudes) == 1 and np.isfinite(self.sigmas[0]):
            return float(self.amplitudes[0] / self.sigmas[0])
        return float(np.sqrt(self.delta_chi2))

    @property
    def plausible(self) -> bool:
        """Whether every amplitude lies in its believed range, its error allowed for."""
        return believed(self.effect, self.amplitudes, self.sigmas)

    def chance_of(self, delta_chi2: float, values: Floats) -> float:
        """Return the chance of a fall, in units of the noise, at fitted values (parameters,)."""
        if one_sided(self.effect):
            risen = values[0] > self.effect.off[0]
            return float(chance_of_falls(np.array(delta_chi2 if risen else 0.0), 1, one_sided=True))
        return float(chance_of_falls(np.array(delta_chi2), self.freedom, one_sided=False))


@dataclass(frozen=True, slots=True, eq=False)
class Ranking:
    """All candidates, the largest expected drop first.

    Attributes
    ----------
    candidates
        In order of their falls; those that cannot be seen last.
    aliases
        Largest correlation between what two candidates do to the residuals, shape (K, K), in the
        same order: near 1 these shots cannot tell them apart.
    imitated
        Share of the drop of candidate i that candidate j could give instead, [i, j], shape
        (K, K).
    chance
        Smallest p over its weight of each of many simulated campaigns with nothing missing,
        sorted.
    noise_scale
        Root of chi-squared per degree of freedom of the fit, by which sigmas were multiplied.
    freedom
        Degrees of freedom of the fit.
    """

    candidates: tuple[Candidate, ...]
    aliases: Floats
    imitated: Floats
    chance: Floats
    noise_scale: float
    freedom: int

    def threshold(self, level: float) -> float:
        """Return what p over weight is below in a share `level` of campaigns without an effect."""
        return float(np.quantile(self.chance, level))


def believed(effect: Effect, values: Floats, sigmas: Floats) -> bool:
    """Return whether values lie in the effect's plausible ranges, two standard errors allowed.

    An error larger than the whole range leaves the value undetermined: that is no belief.
    """
    return all(
        parameter.plausible[0] - BEYOND_RANGE_SIGMAS * sigma
        <= value
        <= parameter.plausible[1] + BEYOND_RANGE_SIGMAS * sigma
        and sigma < np.ptp(parameter.plausible)
        for parameter, value, sigma in zip(effect.parameters, values, sigmas, strict=True)
    )


def weight_of(effect: Effect, *, stated: bool) -> float:
    """Return by what the chance of an effect is weighted among those of all that are looked at.

    Whether the air is as stated is asked before the shots speak, and no law of contact can answer
    in its stead: flights before the contact tell. Errors of images take part in every law, and one
    that is pulled is as likely a sign of another law. Weighted chances keep the family's level:
    C. R. Genovese, K. Roeder and L. Wasserman, Biometrika 93, 509 (2006).
    """
    return STATED_WEIGHT if stated and isinstance(effect, FlightEffect) else 1.0


def one_sided(effect: Effect) -> bool:
    """Return whether an effect's one parameter can have one sign only."""
    return len(effect.parameters) == 1 and effect.parameters[0].one_sided
