"""A campaign of any length fitted, bad shots and frames left out, as `fitting.robust_fit`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.effects.effect import ContactLaw, Effect, ScatterEffect
from analysis.model.data.evidence import corrections
from analysis.model.data.inside import without_contact_frames
from analysis.model.fitting.account import AS_STATED, Account
from analysis.model.fitting.adding import with_law
from analysis.model.fitting.gauss_newton import Purpose
from analysis.model.fitting.noise import scales_over
from analysis.model.fitting.outliers import (
    ROUNDS,
    bad_shots,
    robust_weight,
    starts_afresh,
    wild_frames,
)
from analysis.model.predict.theory import Theory
from analysis.model.rank.candidate import Ranking
from analysis.model.rank.ranking import rank_over
from analysis.model.rank.scatter import jitter_found, jitter_over
from analysis.model.streaming.fit import StreamedFit, fit_stream, passes_of_stream
from analysis.model.streaming.stream import Frame, PoseStream


@dataclass(frozen=True, slots=True, eq=False)
class JudgedStream:
    """A campaign of any length with a fit.

    Attributes
    ----------
    data
        What was fitted.
    fit
        The fit.
    """

    data: PoseStream
    fit: StreamedFit

    @property
    def account(self) -> Account:
        """What was left out, and how large the noise was taken to be."""
        data = self.data
        left = {int(number) for number in data.stated[~data.kept]}
        return Account(
            excluded=list(data.excluded),
            rejected=sorted([*data.unusable, *left]),
            frames=tuple(frame for frame in data.gone if frame[0] not in left),
            noise=data.noise,
            torn=tuple(track for part in data.parts for track in part.torn),
        )

    def ranked(self, effects: Sequence[Effect]) -> Ranking:
        """Score every effect that is not in the fit yet, as `analysis.model.rank.ranking.rank`."""
        return rank_over(passes_of_stream(self.data, self.fit), effects)


def judged_stream(poses: PoseStream, effects: Sequence[Effect] = ()) -> JudgedStream:
    """Fit the base model and some effects; what is bad is judged with these effects in.

    Raises
    ------
    OSError
        The temporary folder is full.
    """
    stated = poses.spooled(without_contact_frames)
    base = _weighed(stated, None)
    if not effects:
        return base
    found = base
    for effect in effects:
        found = _added(found, effect)
    if _untouched(base.data) and found.data.jitter_s == stated.jitter_s:
        return found
    jittered = replace(stated, jitter_s=found.data.jitter_s)
    again = _weighed(jittered, found.fit.theory)
    same = again.account == base.account
    fit = found.fit if same else replace(again.fit, scatter=found.fit.scatter)
    return JudgedStream(again.data, fit)


def _untouched(data: PoseStream) -> bool:
    return bool(data.kept.all()) and not data.gone and data.noise == AS_STATED


def _weighed(stated: PoseStream, theory: Theory | None) -> JudgedStream:
    """Take out what is bad and correct the sigmas, judged by a theory (None: the base model)."""
    cleaned = _clean(stated, theory)
    noise = corrections(scales_over(passes_of_stream(cleaned.data, cleaned.fit)))
    if noise == AS_STATED:
        return cleaned
    return _clean(stated.scaled(*noise), cleaned.fit.theory)


def _clean(stream: PoseStream, theory: Theory | None) -> JudgedStream:
    """Fit robustly, take out wild frames, then shots that still do not fit, and fit again."""
    fit = _robust(stream, theory)
    for _ in range(ROUNDS):
        wild = _wild(stream, fit)
        if not wild:
            break
        stream = stream.without(wild)
        fit = _robust(stream, fit.theory)
    gone = 0
    for _ in range(ROUNDS):
        bad = bad_shots(fit, gone)
        if not bad.any():
            break
        gone += int(bad.sum())
        stream = stream.of_shots(~bad)
        fit = fit_stream(stream, fit.theory, fit.states(~bad))
    # Afresh, now that the law is known: near its corner a shot may have begun on the wrong side.
    fits = [fit_stream(stream, begun) for begun in starts_afresh(fit)]
    return JudgedStream(stream, min(fits, key=lambda one: one.chi2))


def _robust(stream: PoseStream, theory: Theory | None) -> StreamedFit:
    """Fit with bad shots held down, then each shot's own numbers and quality as stated."""
    first = fit_stream(stream, theory)
    weight = robust_weight(first)
    if (weight == 1.0).all():
        return first
    fit = fit_stream(stream.held_down(weight), first.theory)
    return replace(fit, shot_chi2=fit.shot_chi2 / weight**2)


def _wild(stream: PoseStream, fit: StreamedFit) -> list[Frame]:
    """Return the worst frame of each suspicious shot, where it stands out."""
    suspicious: NDArray[np.bool_] = bad_shots(fit)
    if not suspicious.any():
        return []
    found, start = list[Frame](), 0
    for part, states in zip(stream, fit.states(), strict=True):
        bad = suspicious[start : start + len(part.shots)]
        start += len(part.shots)
        if bad.any():
            wild = wild_frames(part, states, fit.theory, bad)
            found += [(int(part.shots[s]), int(k)) for s, k in np.argwhere(wild)]
    return found


def _added(found: JudgedStream, effect: Effect) -> JudgedStream:
    """Fit again with one more effect; one that is noise of its own enters the data's noise."""
    data, fit = found.data, found.fit
    if isinstance(effect, ContactLaw):

        def refit(theory: Theory, start: StreamedFit | None, purpose: Purpose) -> StreamedFit:
            states = None if start is None else start.states()
            return fit_stream(data, theory, states, purpose=purpose)

        return JudgedStream(data, with_law(passes_of_stream(data, fit), fit, effect, refit))
    if not isinstance(effect, ScatterEffect):
        theory = fit.theory.with_effect(effect)
        return JudgedStream(data, fit_stream(data, theory, fit.states(), scatter=fit.scatter))
    score = jitter_over(passes_of_stream(data, fit))
    if score is None:
        return found
    jittered = replace(data, jitter_s=score.amplitude)
    scatter = jitter_found(effect, score.amplitude, score.sigma)
    return JudgedStream(jittered, fit_stream(jittered, fit.theory, fit.states(), scatter=scatter))
