"""What each shot says of a change of each coefficient, and of each force in flight.

A form's column is a channel times f(x) of the shots, so that any number of forms needs one pass.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.operator import Encounter, Operator, Outcome
from analysis.effects.effect import ContactEffect, Effect, Parameter, Values
from analysis.model.data.poses import PoseData
from analysis.model.data.tables import Data
from analysis.model.fitting.fit import Fit, parts_of
from analysis.model.fitting.normal import inverse, solve_blocks, with_prior
from analysis.model.fitting.slow_errors.field import FieldErrors, field_errors
from analysis.model.predict.columns import all_columns
from analysis.model.predict.comparison import compare
from analysis.model.predict.contact import encounter_of
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import Theory
from analysis.model.proposals.forms.flight import FlightForm, flight_forms
from analysis.model.proposals.forms.form import COEFFICIENTS, SLOTS, ContactForm
from analysis.model.proposals.forms.frame import FrameForm, frame_forms
from analysis.model.proposals.forms.impulses import IMPULSES, TORSION, changed_outcome
from analysis.model.rank.projector import ByShot

InFrames = FlightForm | FrameForm
Form = ContactForm | InFrames

LEAST_INFORMATION = 1e-5
"""A column of which less is left is what a fitted number does already."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Linearised:
    """What some channels would change in each shot, about a fit.

    Attributes
    ----------
    by_shot
        Of the channels.
    covariance
        Of what all shots share, shape (P, P).
    left
        What a fit that ends a little before its minimum leaves downhill of it, shape (P,).
    """

    by_shot: ByShot
    covariance: Floats
    left: Floats

    def summed(self, columns: Sequence[tuple[int, Floats]]) -> Sums:
        """Return M and g of columns, each a channel and its weights (S,)."""
        where = np.array([channel for channel, _ in columns], dtype=np.intp)
        # Columns of one channel side by side, so that each pair of channels is one block.
        order = np.argsort(where, kind="stable")
        weight = np.stack([columns[k][1] for k in order], axis=1)
        count, by = len(columns), self.by_shot
        gradient, raw = np.zeros(count), np.zeros(count)
        against = np.zeros((count, len(self.covariance)))
        matrix = np.zeros((count, count))
        channels, starts = np.unique(where[order], return_index=True)
        spans = [slice(*span) for span in pairwise([*starts.tolist(), count])]
        for k, (c, rows) in enumerate(zip(channels, spans, strict=True)):
            own = weight[:, rows]
            gradient[rows] = own.T @ by.gradient[:, c]
            raw[rows] = (own**2).T @ by.raw[:, c]
            against[rows] = own.T @ by.against[:, c]
            for d, others in zip(channels[k:], spans[k:], strict=True):
                product = (own * by.own[:, c, d, None]).T @ weight[:, others]
                matrix[rows, others], matrix[others, rows] = product, product.T
        back = np.argsort(order)
        matrix, against = matrix[np.ix_(back, back)], against[back]
        gradient, raw = gradient[back], raw[back]
        imitated = against @ self.covariance
        return Sums(matrix - imitated @ against.T, gradient - imitated @ self.left, raw)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Channels(Linearised):
    """A campaign about a fit: what any form would change, all that is fitted projected out.

    Its channels are first the slots of the contact, then the columns of `framed`.

    Attributes
    ----------
    encounter
        How the spheres of every shot meet.
    framed
        Forms of flight, camera and clock, one for each further channel, and which of its columns
        that is.
    noise_scale
        Root of chi-squared per degree of freedom, by which sigmas are multiplied.
    """

    encounter: Encounter
    framed: tuple[tuple[InFrames, int], ...]
    noise_scale: float

    def weights(self, form: Form, number: int = 0) -> tuple[int, Floats]:
        """Return the channel of one column of a form, and f of every shot there, shape (S,)."""
        if isinstance(form, ContactForm):
            return SLOTS.index(form.slot), form.columns(self.encounter)[:, number]
        place = next(k for k, (other, n) in enumerate(self.framed) if other is form and n == number)
        return len(SLOTS) + place, np.ones(len(self.by_shot.gradient))


@dataclass(frozen=True, slots=True, eq=False)
class Sums:
    """M (K, K), g (K,) and the raw diagonal of M (K,) of columns, all that is fitted out."""

    matrix: Floats
    gradient: Floats
    raw: Floats

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Which columns these shots see, beside what is fitted, shape (K,)."""
        return np.asarray(np.diag(self.matrix) > LEAST_INFORMATION * np.maximum(self.raw, 1e-300))

    def of(self, columns: NDArray[np.intp] | NDArray[np.bool_]) -> Sums:
        """Return those of some columns."""
        some = np.arange(len(self.gradient))[columns]
        return Sums(self.matrix[np.ix_(some, some)], self.gradient[some], self.raw[some])

    def __add__(self, other: Sums) -> Sums:
        """Return the sums of two campaigns together."""
        return Sums(
            self.matrix + other.matrix, self.gradient + other.gradient, self.raw + other.raw
        )


def channels_of(data: Data, fit: Fit) -> Channels:
    """Linearise about a fit, and project all channels."""
    theory, framed, field = fit.theory, _in_frames(data), field_errors(data)
    probes = [*_PROBES, *(form.effect(f"probe-{k}") for k, form in enumerate(framed))]
    fitted, law = len(theory.names) + field.count, np.arange(len(COEFFICIENTS))
    information, downhill = np.zeros((fitted, fitted)), np.zeros(fitted)
    parts = []
    for part, states in parts_of(data, fit):
        columns = _eliminated(part, states, theory, probes, field)
        information += columns.own[:, :fitted, :fitted].sum(axis=0)
        downhill += columns.gradient[:, :fitted].sum(axis=0)
        chosen = np.concatenate([law, np.arange(fitted, columns.raw.shape[1])])
        # A relative change of a coefficient is so many of its own units.
        scale = np.ones(len(chosen))
        scale[law] = theory.vector[law]
        across = columns.own[:, chosen] * scale[:, None]
        parts.append(
            ByShot(
                own=across[:, :, chosen] * scale,
                against=across[:, :, :fitted],
                gradient=columns.gradient[:, chosen] * scale,
                raw=columns.raw[:, chosen] * scale**2,
            )
        )
    centre, known = theory.prior
    strain, known = field.beside((theory.vector - centre) * known, known)
    return Channels(
        encounter=encounter_of(data, fit.states, theory),
        by_shot=ByShot(*(np.concatenate(numbers) for numbers in zip(*parts, strict=True))),
        framed=tuple((form, k) for form in framed for k in range(len(form.symbols))),
        covariance=inverse(with_prior(information, known)),
        left=downhill - strain,
        noise_scale=float(np.sqrt(max(fit.chi2_per_dof, 1e-12))),
    )


def _eliminated(
    data: Data, states: ShotStates, theory: Theory, probes: Sequence[Effect], field: FieldErrors
) -> ByShot:
    """Return sums of what is fitted, a field and probes, the shots' own numbers eliminated."""
    line, here = compare(data, states, theory)
    given = field.columns(data)
    columns = all_columns(data, states, theory, line=line, here=here, effects=probes, given=given)
    coupling = np.swapaxes(line.by_state, 1, 2) @ columns.against_flights(line)
    eliminated = np.swapaxes(solve_blocks(line.information, coupling), 1, 2)
    gram = columns.gram(line)
    own = gram - eliminated @ coupling
    return ByShot(
        own=own,
        against=own,
        gradient=columns.with_residual(line) - (eliminated @ line.downhill[..., None])[..., 0],
        raw=np.diagonal(gram, axis1=1, axis2=2),
    )


def _in_frames(data: Data) -> list[InFrames]:
    """Return the forms that poses of two spheres can show; a table has no frames."""
    a, b = data.bodies
    if not isinstance(data, PoseData) or b.is_plate:
        return []
    return [*flight_forms(a.radius + b.radius, a.mass), *frame_forms()]


def _probe(slot: str, parameter: Parameter) -> Effect:
    """Return a small change of a slot that is no coefficient."""

    def wrap(operator: Operator, values: Values) -> Operator:
        def changed(encounter: Encounter) -> Outcome:
            change = np.full(len(encounter.e), values[0])
            return changed_outcome(slot, operator(encounter), encounter, change)

        return changed

    return ContactEffect(
        name=f"{slot}-probe",
        title=slot,
        parameters=(parameter,),
        formula="an impulse or a torque that no coefficient sets",
        source="K. L. Johnson, Contact Mechanics (1985), section 3.9",
        gives_away=f"{slot} of the shots",
        wrap=wrap,
    )


_PROBES = (
    _probe(TORSION, Parameter("c", "m", "radius of contact", (-5e-3, 5e-3), step=1e-7)),
    *(_probe(s, Parameter("c", "1", "relative change", (-0.9, 0.9), step=1e-5)) for s in IMPULSES),
)
