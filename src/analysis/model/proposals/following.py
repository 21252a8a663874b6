"""The next shots of a proposal: what tells it from its rival, or confirms it by themselves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.operator import Encounter
from analysis.errors import LaunchRefusedError
from analysis.launch.fit import fit_launch
from analysis.launch.prediction import Limits
from analysis.launch.settings import OFFSET, PRESSURES
from analysis.model.data.poses import PoseData
from analysis.model.design.between import Repeated, tell_apart
from analysis.model.design.candidates import Setting, grid
from analysis.model.design.misfit import MisfitError
from analysis.model.design.undecided import fired_alike, used_limits
from analysis.model.fitting.fit import fit_campaign
from analysis.model.proposals.channels import channels_of
from analysis.model.proposals.forms.form import ContactForm
from analysis.model.proposals.launch_search import LaunchProposal
from analysis.model.proposals.proposed import Accepted, Proposed

RIVAL = "rival"
CONFIRMING_D = 4.0
"""Standard errors of the amplitude from new shots alone: p below 0.01 in 92 campaigns of 100."""
PLACES, FEWEST, MOST = 4, 16, 400
"""Settings of each half of a design, and shots in all."""


def next_after(proposed: Proposed, limits: Limits | None = None) -> tuple[Repeated, ...]:
    """Return the shots that tell the first proposal from its rival, or confirm it without one.

    None where nothing is proposed, or the campaign's settings are not known.

    Parameters
    ----------
    limits
        What the rig allows; None: what the campaign has used.
    """
    data = proposed.data
    if not (proposed.accepted or proposed.launch) or not isinstance(data, PoseData):
        return ()
    if any(name not in data.covariates for name in (*PRESSURES, OFFSET)):
        return ()
    if not proposed.accepted:
        return _relaunched(data, proposed.launch[0], proposed.encounter, limits)
    first = proposed.accepted[0]
    return _against_rival(proposed, data, first, limits) or _confirming(
        proposed, data, first, limits
    )


def _against_rival(
    proposed: Proposed, data: PoseData, first: Accepted, limits: Limits | None
) -> tuple[Repeated, ...]:
    """Return shots that separate two forms; none where no setting does, or neither form fits."""
    if first.rival is None:
        return ()
    fit = proposed.fit
    base = fit_campaign(data, fit.theory.without_effect(first.name), fit)
    pair = first.rival.effect(RIVAL), first.form.effect(first.name)
    try:
        launch = fit_launch(data, fit)
        settings = grid(limits or used_limits(data), alike=fired_alike(data))
        return tell_apart(data, base, launch, pair, settings).shots
    except (LaunchRefusedError, MisfitError, KeyError):
        return ()


def _confirming(
    proposed: Proposed, data: PoseData, first: Accepted, limits: Limits | None
) -> tuple[Repeated, ...]:
    """Return settings of the campaign where the form says most, half of them where it says least.

    What sets the coefficient itself must be told from what changes it, so both ends are needed.
    """
    fit = proposed.fit
    without = fit_campaign(data, fit.theory.without_effect(first.name), fit)
    channels = channels_of(data, without)
    form = first.form
    if not isinstance(form, ContactForm):
        # One of the exponents that are tried sees the same shots best.
        form = next(f for f, _ in channels.framed if (f.group, f.kind) == (form.group, form.kind))
    channel, size = channels.weights(form)
    own = channels.by_shot.own[:, channel, channel]
    allowed = _allowed(data, limits)
    ends = _ends(np.asarray(size), np.where(allowed, own, 0.0))
    ends = ends[allowed[ends]]
    if not ends.size:
        return ()
    needed = _count(first, size[ends], own[ends])
    each = int(np.clip(np.ceil(needed / len(ends)), 1, MOST))
    return tuple(Repeated(_setting(data, int(shot)), each) for shot in ends)


def _relaunched(
    data: PoseData, one: LaunchProposal, encounter: Encounter, limits: Limits | None
) -> tuple[Repeated, ...]:
    """Return settings of the campaign at both ends of what a launch follows."""
    values = one.form.of.of(encounter)[:, 0]
    order = np.argsort(values)
    order = order[_allowed(data, limits)[order]]
    ends = np.concatenate([order[:PLACES], order[PLACES:][-PLACES:]])
    if not ends.size:
        return ()
    amplitude = next(iter(one.parameters.values()))
    share = (CONFIRMING_D * amplitude.sigma / max(abs(amplitude.value), 1e-300)) ** 2
    needed = np.clip(share * len(values), FEWEST, MOST)
    each = int(np.ceil(needed / len(ends)))
    return tuple(Repeated(_setting(data, int(shot)), each) for shot in ends)


def _ends(size: Floats, own: Floats) -> NDArray[np.intp]:
    """Return the shots that see most where the form is least and where it is most."""
    half = size > np.median(size) if np.ptp(size) > 0 else own > np.median(own)
    chosen = []
    for side in (half, ~half):
        shots = np.flatnonzero(side)
        contrast = np.abs(size[shots] - np.median(size)) if np.ptp(size) > 0 else 1.0
        chosen.append(shots[np.argsort(-own[shots] * contrast)[:PLACES]])
    return np.concatenate(chosen)


def _count(first: Accepted, size: Floats, own: Floats) -> float:
    """Return how many shots at these settings make the amplitude so many standard errors."""
    active = next(a for a in first.found.fit.theory.active if a.effect.name == first.name)
    information = float((own * size**2).sum())
    if np.ptp(size) > 0:
        information -= float((own * size).sum()) ** 2 / max(float(own.sum()), 1e-300)
    each = information / len(size) * float(active.values[0]) ** 2
    return float(np.clip(CONFIRMING_D**2 / max(each, 1e-12), FEWEST, MOST))


def _allowed(data: PoseData, limits: Limits | None) -> NDArray[np.bool_]:
    """Return which shots' settings the rig allows, shape (S,)."""
    allowed = np.ones(len(data.shots), dtype=np.bool_)
    if limits is None:
        return allowed
    ranges = {**dict.fromkeys(PRESSURES, limits.pressure_kpa), OFFSET: limits.offset_mm}
    for name, (low, high) in ranges.items():
        allowed &= (data.covariates[name] >= low) & (data.covariates[name] <= high)
    return allowed


def _setting(data: PoseData, shot: int) -> Setting:
    a, b = (float(data.covariates[name][shot]) for name in PRESSURES)
    return Setting(a, b, float(data.covariates[OFFSET][shot]))
