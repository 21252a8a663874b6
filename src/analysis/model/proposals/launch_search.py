"""What the launch depends on, beyond its catalogue: speeds and tracks against the shot list.

The same screen as for the contact, on launches traced back to the mouths: columns projected off
pushers and tubes, the threshold from the largest of Gaussian draws. Scatter from shot to shot is in
the errors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.collision.operator import Encounter
from analysis.effects.catalogue import LAUNCH_CATALOGUE
from analysis.effects.effect import LaunchEffect
from analysis.errors import LaunchRefusedError
from analysis.launch.fit import fit_launch, settled
from analysis.launch.ranking import rank_launch
from analysis.launch.result import LaunchFit
from analysis.launch.theory import LaunchTheory
from analysis.model.data.poses import PoseData
from analysis.model.data.tables import Data
from analysis.model.fitting.adding import ALIAS_WITHIN
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.normal import inverse
from analysis.model.loops.blocks import whitened
from analysis.model.proposals.admissible import FEWEST_SHOTS, LEAST_SIGMAS
from analysis.model.proposals.arguments import Argument, is_column
from analysis.model.proposals.blocks import blocks_of
from analysis.model.proposals.channels import Linearised, Sums
from analysis.model.proposals.forms.launch import QUANTITIES, LaunchForm, launch_forms
from analysis.model.proposals.screen import Screen, columns_of, scored
from analysis.model.rank.projector import ByShot
from analysis.quantity import Quantity

LEVEL = 0.005
"""Family-wise, beside the 0.03 of all other forms."""
MOST, MOST_TRIED, MOST_REFITTED, FOLDS = 3, 3, 10, 5
PREFERRED, PENALTY = 2.0, 2.0
NAME = "launch-proposal"


@dataclass(frozen=True, slots=True, eq=False)
class LaunchProposal:
    """One form of the launch that went in.

    Attributes
    ----------
    form
        With its constants as fitted.
    name
        Of its effect in the fit.
    parameters
        Amplitudes and constants with their standard errors.
    shapes, alike
        Shapes, and other arguments, that these shots do not tell from it; the best first.
    p_familywise
        Of its score.
    error_before, error_after
        On launches left out, in units of the scatter that the later fit finds.
    """

    form: LaunchForm
    name: str
    parameters: dict[str, Quantity]
    shapes: tuple[str, ...]
    alike: tuple[tuple[str, str], ...]
    p_familywise: float
    error_before: float
    error_after: float


@dataclass(frozen=True, slots=True, eq=False)
class _Tried:
    """A form in a fit of its own; `worth` is the fall of -2 ln L less what constants bring."""

    form: LaunchForm
    fit: LaunchFit
    worth: float


def propose_launch(
    data: Data, fit: Fit, encounter: Encounter, arguments: Sequence[Argument]
) -> tuple[LaunchProposal, ...]:
    """Propose what the launches depend on; nothing where the settings are not known.

    Parameters
    ----------
    fit
        With everything in that was found of contact, flight, camera and clock.
    arguments
        Those that are admitted; of them columns of the shot list take part.
    """
    if not isinstance(data, PoseData) or data.bodies[1].is_plate:
        return ()
    try:
        launch = fit_launch(data, fit)
    except LaunchRefusedError:
        return ()
    kept = np.isin(data.shots, launch.shots)
    if kept.sum() < FEWEST_SHOTS:
        return ()
    columns = [(a, a.of(encounter)[kept, 0]) for a in arguments if is_column(a)]
    folds = blocks_of(data)[kept]
    found = list[LaunchProposal]()
    while len(found) < MOST:
        step = _step(launch, launch_forms(columns), folds, len(found))
        if step is None:
            break
        launch, one = step
        if one is not None:
            columns = [c for c in columns if c[0].name != one.form.argument]
            found.append(one)
    return tuple(found)


def _step(
    launch: LaunchFit, forms: Sequence[LaunchForm], folds: NDArray[np.intp], taken: int
) -> tuple[LaunchFit, LaunchProposal | None] | None:
    """Take in the best form, or an effect of the catalogue that does as well; None: neither."""
    sums, screen = _scored(launch, forms)
    known = _with_known(launch)
    groups = screen.groups()
    passing = {g for g, z in groups.items() if z >= screen.threshold(LEVEL)}
    tried = _refitted(launch, forms, sums, passing) if passing else []
    if known is not None and (not tried or known[1] > tried[0].worth - PREFERRED):
        return known[0], None
    for one in [one for one in tried if one.form.group in passing][:MOST_TRIED]:
        name = f"{NAME}-{taken + 1}"
        fit, freed, form = _with_constants(launch, one, name)
        errors = _errors(launch, fit, folds)
        if not _determined(fit, form) or errors[1] >= errors[0]:
            continue
        near = [other for other in tried if other.worth > one.worth - ALIAS_WITHIN]
        own = [o.form.shape_name for o in near if o.form.group == form.group]
        others = [o.form.group for o in near if o.form.group != form.group]
        own_name = f"{name}."
        parameters = {
            key.removeprefix(own_name): quantity
            for key, quantity in freed.parameters().items()
            if key.startswith(own_name)
        }
        return fit, LaunchProposal(
            form=form,
            name=name,
            parameters=parameters,
            shapes=tuple(dict.fromkeys([form.shape_name, *own])),
            alike=tuple(dict.fromkeys(others)),
            p_familywise=screen.p_familywise(groups[form.group]),
            error_before=errors[0],
            error_after=errors[1],
        )
    return None


def _scored(launch: LaunchFit, forms: Sequence[LaunchForm]) -> tuple[Sums, Screen]:
    """Score every column of every form, all that is fitted projected out."""
    about = _about(launch, forms)
    places = {quantity: k for k, quantity in enumerate(QUANTITIES)}
    columns = columns_of(forms)
    weights = [(places[f.quantity], f.columns()[:, number]) for f, number in columns]
    sums = about.summed(weights)
    return sums, scored(columns, sums, 1.0, np.random.default_rng(0))


def _about(launch: LaunchFit, forms: Sequence[LaunchForm]) -> Linearised:
    """Return what each quantity's change would do in each shot, in units of its error."""
    predicted = launch.theory.launch(launch.settings, launch.touches.ground)
    one = {form.quantity: form for form in forms}
    changes = np.stack([one[q].direction(predicted) for q in QUANTITIES if q in one], axis=-1)
    own = whitened(launch.compared.variance(launch.scatter), changes)
    residual, derivative = launch.compared.whitened(launch.scatter)
    centre, width = launch.theory.prior
    flat = derivative.reshape(-1, derivative.shape[-1])
    covariance = inverse(flat.T @ flat + np.diag(width**-2))
    pull = flat.T @ residual.reshape(-1) - (launch.theory.vector - centre) / width**2
    by_column = np.swapaxes(own, 1, 2)
    return Linearised(
        by_shot=ByShot(
            own=by_column @ own,
            against=by_column @ derivative,
            gradient=np.einsum("sic,si->sc", own, residual),
            raw=(own**2).sum(axis=1),
        ),
        covariance=covariance,
        left=np.asarray(pull),
    )


def _refitted(
    launch: LaunchFit, forms: Sequence[LaunchForm], sums: Sums, passing: set[tuple[str, str]]
) -> list[_Tried]:
    """Fit the likeliest forms of each group again, the most worth first."""
    scored, start = [], 0
    for form in forms:
        block = sums.of(np.arange(start, start + len(form.symbols)))
        start += len(form.symbols)
        if block.seen.all() and form.group in passing:
            solved = np.linalg.lstsq(block.matrix, block.gradient, rcond=1e-10)[0]
            scored.append((float(block.gradient @ solved), form))
    best: dict[tuple[str, str, str], tuple[float, LaunchForm]] = {}
    for delta_chi2, form in scored:
        key = form.quantity, form.argument, form.shape_name
        if key not in best or delta_chi2 > best[key][0]:
            best[key] = delta_chi2, form
    chosen = sorted(best.values(), key=lambda pair: -pair[0])[:MOST_REFITTED]
    tried = []
    for _, form in chosen:
        fit = settled(launch.theory.with_effect(form.effect(NAME)), launch)
        sought = len(form.free) + len(form.symbols) - 1
        tried.append(_Tried(form, fit, fall_of(launch, fit) - PENALTY * sought))
    return sorted(tried, key=lambda one: -one.worth)


def _with_known(launch: LaunchFit) -> tuple[LaunchFit, float] | None:
    """Fit the best effect of the catalogue, and say what it brings; None: none is asked for."""
    for one in rank_launch(launch, LAUNCH_CATALOGUE).candidates:
        if one.seen and not one.fitted and one.plausible and one.p_familywise < LEVEL:
            effect: LaunchEffect = one.effect
            fit = settled(launch.theory.with_effect(effect), launch)
            return fit, fall_of(launch, fit)
    return None


def _with_constants(
    launch: LaunchFit, one: _Tried, name: str
) -> tuple[LaunchFit, LaunchFit, LaunchForm]:
    """Fit the constants of a form too; return the fit with them held, and free, and the form."""
    form, count = one.form, len(one.form.symbols)
    if form.free:
        theory = launch.theory.with_effect(form.freed(name))
        start = np.concatenate([launch.theory.vector, one.fit.theory.vector[-count:]])
        scales = form.constants[len(form.constants) - len(form.free) :]
        freed = settled(theory.at(np.concatenate([start, scales])), launch)
        moved = form.at(*freed.theory.vector[-len(form.free) :])
        if np.isfinite(moved.columns()).all() and fall_of(one.fit, freed) > 0:
            held = settled(launch.theory.with_effect(moved.effect(name)), launch)
            return held, freed, moved
    held = settled(launch.theory.with_effect(form.effect(name)), launch)
    return held, held, form


def fall_of(before: LaunchFit, after: LaunchFit) -> float:
    """Return by how much -2 ln L falls, scatter and all."""
    return _deviance(before) - _deviance(after)


def _deviance(launch: LaunchFit) -> float:
    residual, _ = launch.compared.whitened(launch.scatter)
    variance = launch.compared.variance(launch.scatter)
    return float((residual**2).sum() + np.linalg.slogdet(variance)[1].sum())


def _determined(fit: LaunchFit, form: LaunchForm) -> bool:
    """Whether an amplitude is far from zero, and all are in their ranges."""
    values = fit.theory.vector[-len(form.symbols) :]
    sigmas = np.sqrt(np.diag(fit.covariance))[-len(form.symbols) :]
    inside = [
        p.plausible[0] <= v <= p.plausible[1]
        for p, v in zip(form.amplitudes(), values, strict=True)
    ]
    return bool((np.abs(values) > LEAST_SIGMAS * sigmas).any()) and all(inside)


def _errors(before: LaunchFit, after: LaunchFit, blocks: NDArray[np.intp]) -> tuple[float, float]:
    """Return errors on launches left out, at random; infinite after where blocks disagree."""
    first, second = errors_left_out(before, after)
    apart = _left_out(before.theory, after, blocks), _left_out(after.theory, after, blocks)
    return first, second if apart[1] < apart[0] else np.inf


def errors_left_out(before: LaunchFit, after: LaunchFit) -> tuple[float, float]:
    """Return errors of two fits on launches left out at random, in units of the later scatter."""
    draw = np.random.default_rng(0).permutation(len(after.shots)) % FOLDS
    return _left_out(before.theory, after, draw), _left_out(after.theory, after, draw)


def _left_out(theory: LaunchTheory, judge: LaunchFit, folds: NDArray[np.intp]) -> float:
    """Return the error on launches left out, in units of the errors that `judge` has."""
    fit = judge if theory is judge.theory else settled(theory, judge)
    residual, derivative = fit.compared.whitened(judge.scatter)
    centre, width = theory.prior
    total, pull = np.diag(width**-2), -(fit.theory.vector - centre) / width**2
    flat = derivative.reshape(-1, derivative.shape[-1])
    information, gradient = flat.T @ flat + total, flat.T @ residual.reshape(-1) + pull
    squares = 0.0
    for fold in np.unique(folds):
        out = folds == fold
        own = derivative[out].reshape(-1, derivative.shape[-1])
        wrong = residual[out].reshape(-1)
        step = inverse(information - own.T @ own) @ (gradient - own.T @ wrong)
        squares += float(((wrong - own @ step) ** 2).sum())
    return float(np.sqrt(squares / residual.size))
