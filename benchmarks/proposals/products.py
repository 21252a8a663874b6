"""Products of two arguments at one strength, by what either argument does by itself.

With the zero of one argument off the mean of the shots, the other by itself does most of what the
product does. At a strength d the product is then told from it by d sqrt(1 - share) standard errors
only, among a dozen partners that it may have.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.model.data.inside import without_contact_frames
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import fit_campaign
from analysis.model.proposals.arguments import known_arguments
from analysis.model.proposals.channels import Channels, channels_of
from analysis.model.proposals.forms.form import ContactForm
from analysis.model.proposals.rivals import alone
from benchmarks.discovery.campaigns import SILENCE, STATED, posed
from benchmarks.proposals.likelihood import found_by_likelihood
from simulators.challenge.campaign import Noise, run_campaign
from simulators.challenge.launch import Settings, Touch
from simulators.challenge.nature import Nature
from simulators.challenge.unnamed import Dependence, Law

Floats = NDArray[np.float64]
Of = Callable[[Settings, Touch, float], Floats]

WAYS_OFF = (0, 1, 2)
"""Of a zero from the mean of the shots, in their standard deviations."""
FIRST_GUESS = 0.01
"""Amplitude from which the one of a strength is found, for arguments of unit spread."""
SHARES = (0.0, 0.6, 0.8, 0.9, 1.0)
"""Of what a product does, done by its arguments by themselves: between these, rates are printed."""


@dataclass(frozen=True, slots=True)
class Pair:
    """A coefficient and two arguments; the zero of the first is the one that lies off.

    Attributes
    ----------
    names
        Of the first and of the second.
    """

    slot: str
    names: tuple[str, str]
    first: Of
    second: Of

    @property
    def group(self) -> tuple[str, str]:
        """Slot and argument as proposals have them."""
        return self.slot, "*".join(sorted(self.names))


def _ln_approach(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return np.asarray(np.log(touch.approach))


def _ln_slip(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    slip = np.linalg.norm(touch.slip(radius_m), axis=1)
    return np.asarray(np.log(np.maximum(slip, 0.01)))


def _warmth(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return np.asarray(settings.temperature_c)


def _order(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return settings.order


PAIRS = (
    Pair("e", ("speed_n", "temperature_c"), _ln_approach, _warmth),
    Pair("mu", ("speed_s", "temperature_c"), _ln_slip, _warmth),
    Pair("e", ("order", "speed_n"), _order, _ln_approach),
)
"""One of them for each seed in turn."""


@dataclass(frozen=True, slots=True)
class Made:
    """A campaign that hides a product.

    Attributes
    ----------
    share
        Of what the product does, done by its arguments by themselves.
    likely
        How often likelihood alone has it among the three likeliest.
    """

    data: PoseData
    pair: Pair
    share: float
    likely: float


def product_at(d: float, off: int, seed: int, shots: int, *, own: bool = False) -> Made:
    """Return a campaign that hides a product at a strength, its zero so far off.

    Parameters
    ----------
    own
        Whether the strength is of what the arguments by themselves do not do, and not of all that
        the product does.
    """
    pair = PAIRS[seed % len(PAIRS)]

    def size(settings: Settings, touch: Touch, radius_m: float) -> Floats:
        first, second = (
            _standard(of(settings, touch, radius_m)) for of in (pair.first, pair.second)
        )
        return np.asarray((first + off) * second)

    def campaign(amplitude: float, noise: Noise) -> PoseData:
        law = Law(*pair.group, "linear", size, "1", "a product", amplitude)
        nature = Nature(dependence=Dependence(law, amplitude))
        return posed(run_campaign(nature, seed, shots=shots, noise=noise))

    silent = without_contact_frames(campaign(FIRST_GUESS, SILENCE))
    fit = fit_campaign(silent)
    channels = channels_of(silent, fit)
    product = true_product(channels, pair, off)
    share = share_alone(channels, product)
    left = np.sqrt(1.0 - share if own else 1.0)
    found = float(np.sqrt(fit.chi2)) * left
    likely = found_by_likelihood(channels, product, d / left, seed)
    return Made(campaign(FIRST_GUESS * d / found, STATED), pair, share, likely)


def true_product(channels: Channels, pair: Pair, off: int) -> ContactForm:
    """Return what is hidden, as a form."""
    offered = known_arguments(channels.encounter, scalars=False, one_frame=True)
    known = {argument.name: argument for argument in offered}
    arguments = tuple(known[name] for name in pair.names)
    zeros = []
    for argument, away in zip(arguments, (off, 0), strict=True):
        values = argument.of(channels.encounter)[:, 0]
        values = np.log(values) if argument.positive else values
        zero = float(values.mean() - away * values.std())
        zeros.append(float(np.exp(zero)) if argument.positive else zero)
    return ContactForm(pair.slot, arguments, None, tuple(zeros), (1.0,))


def share_alone(channels: Channels, product: ContactForm) -> float:
    """Return the share of what a product does that its arguments do by themselves."""
    forms = product, alone(product, 0), alone(product, 1)
    matrix = channels.summed([channels.weights(form) for form in forms]).matrix
    across = matrix[0, 1:]
    return float(across @ np.linalg.solve(matrix[1:, 1:], across) / matrix[0, 0])


def _standard(values: Floats) -> Floats:
    return np.asarray((values - values.mean()) / values.std())
