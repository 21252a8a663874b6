"""The best form of a slot and an argument by score: every shape at its likeliest constants."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.model.data.tables import Data
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.fitting.gauss_newton import TO_THE_END, Purpose
from analysis.model.proposals.arguments import Argument
from analysis.model.proposals.channels import Channels, Form, Sums
from analysis.model.proposals.forms.flight import FlightForm
from analysis.model.proposals.forms.form import OF_A_PRODUCT, ContactForm
from analysis.model.proposals.forms.impulses import IMPULSES
from analysis.model.proposals.forms.shapes import spread_of
from analysis.model.proposals.screen import FULL_SLOTS, columns_of, shaped, shapes_of

FINE = 3
MOST_SHAPES, MOST_GROUPS = 4, 8
PENALTY = 2.0
"""Of deviance, for each constant and each further amplitude that was sought (Akaike)."""
OF_SETTING = 4.0
OF_FADING = 4.0
"""Charged to a force that fades exponentially: one without a length of its own goes first."""
OF_IMPULSE = 4.0
"""Charged to an impulse that changes by itself: where a coefficient does it, that is named."""
OF_ZEROS = 14.0
"""Charged to a product whose zeros are free, and so is its partner: one of the two arguments alone
goes first unless the other is seen beside it, as 1 in 1000 pairs of arguments is by chance."""
CARRIERS = 2


@dataclass(frozen=True, slots=True, eq=False)
class ScoredForm:
    """A form at its likeliest constants.

    Attributes
    ----------
    delta_chi2
        Of chi-squared that its amplitudes would bring, in units of the noise.
    start
        These amplitudes.
    carried_share
        Share of the fall that is gone without the two shots that speak loudest for it.
    widths
        Of each free constant, half of the range over which the fall stays within 1 of this one.
    zeros_sought
        Whether the zeros of a product were fitted before it was compared.
    """

    form: Form
    delta_chi2: float
    start: Floats
    carried_share: float
    widths: tuple[float, ...] = ()
    zeros_sought: bool = False

    @property
    def worth(self) -> float:
        """Fall less what its constants and further amplitudes would bring by chance.

        Of a setting of the rig less still: what it does is done by how the spheres meet.
        """
        # The zeros of a product stay where they are until it goes in.
        free = () if self.form.free == OF_A_PRODUCT else self.form.free
        sought = len(free) + len(self.form.symbols) - 1
        charge = OF_SETTING if _is_setting(self.form) else 0.0
        charge += OF_FADING if _fades(self.form) else 0.0
        charge += OF_IMPULSE if self.form.slot in IMPULSES else 0.0
        charge += OF_ZEROS if self.zeros_sought else 0.0
        return self.delta_chi2 - PENALTY * sought - charge


@dataclass(frozen=True, slots=True, eq=False)
class Refitted:
    """A form in a fit of its own, beside all that was fitted before."""

    scored: ScoredForm
    name: str
    fit: Fit
    delta_chi2: float

    @property
    def form(self) -> Form:
        """The form."""
        return self.scored.form

    @property
    def worth(self) -> float:
        """Fall as the refit brought it, less what constants bring by chance."""
        return self.scored.worth - self.scored.delta_chi2 + self.delta_chi2


Rival = ScoredForm | Refitted
"""A form with what it is worth: as its score has it, or as a fit of its own."""


def score_forms(
    channels: Channels, group: tuple[str, str], forms: Sequence[Form]
) -> list[ScoredForm]:
    """Return the best form of each shape of a group, the most worth first."""
    own = [form for form in forms if form.group == group]
    finer: list[Form] = []
    sought = set[tuple[tuple[str, str], str]]()
    for form in own:
        if not isinstance(form, ContactForm) or len(form.arguments) > 1 or form.shape is None:
            finer.append(form)
            continue
        argument: Argument = form.arguments[0]
        if (argument.key, form.shape.name) in sought:
            continue
        sought.add((argument.key, form.shape.name))
        shapes = shapes_of(argument) if form.slot in FULL_SLOTS else (form.shape,)
        for shape in shapes:
            if shape.name == form.shape.name:
                spread = spread_of(argument.of(channels.encounter)[:, 0])
                finer += shaped(channels, form.slot, argument, shape, spread, fine=FINE)
    tried: dict[tuple[str, str], list[ScoredForm]] = {}
    for scored in _score(channels, finer):
        tried.setdefault((scored.form.shape_name, _variable(scored.form)), []).append(scored)
    best = [_with_widths(scored_forms) for scored_forms in tried.values()]
    return sorted(best, key=lambda scored: -scored.worth)[:MOST_SHAPES]


def _with_widths(tried: Sequence[ScoredForm]) -> ScoredForm:
    """Return the best form of one shape, and how well these shots hold its constants."""
    best = max(tried, key=lambda scored: scored.delta_chi2)
    count = len(best.form.free)
    if best.form.free == OF_A_PRODUCT or not count:
        return best
    values = np.array([one.form.constants[-count:] for one in tried])
    near = values[np.array([one.delta_chi2 > best.delta_chi2 - 1.0 for one in tried])]
    # A range that holds one value that is tried alone is no wider than the way to the next.
    gaps = [np.diff(np.unique(column)) for column in values.T]
    least = np.array([gap.min() if gap.size else np.inf for gap in gaps])
    widths = np.maximum(np.ptp(near, axis=0), least) / 2
    return replace(best, widths=tuple(map(float, widths)))


def _is_setting(form: Form) -> bool:
    return isinstance(form, ContactForm) and any(a.is_setting for a in form.arguments)


def _fades(form: Form) -> bool:
    return isinstance(form, FlightForm) and form.kind == "central-exponential"


def _variable(form: Form) -> str:
    return form.arguments[0].symbol if isinstance(form, ContactForm) else ""


def _score(channels: Channels, forms: Sequence[Form]) -> list[ScoredForm]:
    columns = columns_of(forms)
    weights = [channels.weights(form, number) for form, number in columns]
    sums = channels.summed(weights)
    pulls = np.stack([w * channels.by_shot.gradient[:, c] for c, w in weights], axis=1)
    starts = np.cumsum([0, *(len(form.symbols) for form in forms)])[:-1]
    found: dict[int, ScoredForm] = {}
    for size in {len(form.symbols) for form in forms}:
        alike = [k for k, form in enumerate(forms) if len(form.symbols) == size]
        own = starts[alike, None] + np.arange(size)
        kept = np.flatnonzero(sums.seen[own].all(axis=1))
        solved = _solved(sums, pulls, own[kept])
        for k, amplitudes, delta_chi2, share in zip(np.array(alike)[kept], *solved, strict=True):
            worth = float(delta_chi2) / channels.noise_scale**2
            found[int(k)] = ScoredForm(forms[k], worth, amplitudes, float(share))
    return [found[k] for k in sorted(found)]


def _solved(sums: Sums, pulls: Floats, own: NDArray[np.intp]) -> tuple[Floats, Floats, Floats]:
    """Solve for the amplitudes of forms of one size.

    Parameters
    ----------
    pulls
        Every shot's part of the gradient, shape (S, K).
    own
        Columns of each form, shape (N, size).

    Returns
    -------
    Amplitudes, shape (N, size); the fall of chi-squared that they bring, and which share of it the
    shots bring that carry most of it, both of shape (N,).
    """
    gradient = sums.gradient[own]
    inverses = np.linalg.pinv(
        sums.matrix[own[:, :, None], own[:, None, :]], rcond=1e-10, hermitian=True
    )
    amplitudes = (inverses @ gradient[..., None])[..., 0]
    delta_chi2 = (gradient * amplitudes).sum(axis=1)
    by_shot = pulls[:, own]
    brought = (by_shot * amplitudes).sum(axis=2)
    carriers = np.argsort(brought, axis=0)[-CARRIERS:]
    rest = gradient - np.take_along_axis(by_shot, carriers[..., None], axis=0).sum(axis=0)
    left = (rest[:, None] @ inverses @ rest[..., None])[:, 0, 0]
    share = 1.0 - np.divide(left, delta_chi2, out=np.zeros_like(left), where=delta_chi2 > 0)
    return amplitudes, delta_chi2, share


def refitted(
    data: Data, fit: Fit, scored: ScoredForm, name: str, purpose: Purpose = TO_THE_END
) -> Refitted:
    """Fit again with a form, its constants held."""
    theory = fit.theory.with_effect(scored.form.effect(name))
    again = fit_campaign(data, theory, fit, purpose)
    noise = max(again.chi2_per_dof, 1e-12)
    return Refitted(scored, name, again, (fit.chi2 - again.chi2) / noise)


def with_free_constants(data: Data, found: Refitted) -> tuple[Refitted, Fit]:
    """Fit the constants of a form too, from where they are.

    Returns
    -------
    The form at these constants, and the fit in which they are free; as it was where it has none,
    or where they run away.
    """
    form, values = found.form, _values(found.fit, found.name)
    if not form.free:
        return found, found.fit
    start = np.concatenate([values, form.constants[-len(form.free) :]])
    theory = found.fit.theory.without_effect(found.name)
    freed = fit_campaign(data, theory.with_effect(form.freed(found.name), start), found.fit)
    values = _values(freed, found.name)
    constants = values[len(form.symbols) :]
    # The same form, with what a fit determines of it: its type stays.
    moved = form.at(*constants)
    effect = moved.effect(found.name)
    rest = freed.theory.without_effect(found.name)
    theory = rest.with_effect(effect, values[: len(form.symbols)])
    again = fit_campaign(data, theory, freed)
    if not np.isfinite(values).all() or again.chi2 > found.fit.chi2 + 1e-6:
        return found, found.fit
    delta_chi2 = found.delta_chi2 + (found.fit.chi2 - again.chi2) / max(again.chi2_per_dof, 1e-12)
    return Refitted(replace(found.scored, form=moved), found.name, again, delta_chi2), freed


def _values(fit: Fit, name: str) -> Floats:
    return np.asarray(next(a.values for a in fit.theory.active if a.effect.name == name))
