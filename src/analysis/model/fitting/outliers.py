"""Bad frames and bad shots: a mis-tracked marker must not become physics.

Frames first: a wild frame makes its whole shot look bad. Whatever is taken out is listed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from analysis.arrays import Floats
from analysis.model.data.poses import Frame, PoseData
from analysis.model.data.stream import CampaignData, PoseStream
from analysis.model.data.tables import ContactTable
from analysis.model.fitting.fit import FEW, Fit, fit_afresh, fit_campaign, states_of_shots
from analysis.model.fitting.summary import FitSummary
from analysis.model.predict.linear import whitened_residual
from analysis.model.predict.prediction import predict
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import Theory

ROUNDS = 4
FEWEST = 6
"""Of fewer shots none is bad for lying off the others: the fastest of five may be the physics."""
ALARM_SHARE = 0.005
"""Of a campaign without bad shots this share has one called bad."""
WILD_FRAME, WILD_AGAINST_MEDIAN, WILD_AGAINST_NEXT = 45.0, 6.0, 2.5
"""Chi-squared of a frame's 12 numbers: at least this, and against the shot's other frames."""
PHYSICS_SHARE = 0.15
"""If more shots than this look bad, it is the model that is."""
FAR_OUT = 6.0
"""Then only shots beyond the upper quartile by this many interquartile ranges are dropped."""


@dataclass(frozen=True, slots=True, eq=False)
class Cleaned:
    """A campaign without its bad frames and shots, and the fit of what is left.

    Attributes
    ----------
    data, fit
        What is left.
    kept
        Mask of the shots that were kept, shape (S,) of the data handed in.
    frames
        (shot number, frame index) of frames that were taken out of shots that were kept.
    far
        Chi-squared per degree of freedom of each shot that was taken out, by its number, in units
        of the campaign's median.
    """

    data: CampaignData
    fit: Fit
    kept: NDArray[np.bool_]
    frames: tuple[Frame, ...]
    far: Mapping[int, float]


def clean(data: CampaignData, theory: Theory | None = None) -> Cleaned:
    """Fit robustly, take out wild frames, then shots that still do not fit, and fit again."""
    whole, first = data, fit_campaign(data, theory)
    fit = _robust(data, first)
    frames: list[Frame] = []
    for _ in range(ROUNDS):
        if isinstance(data, ContactTable):
            break
        wild = _wild(data, fit)
        if not wild:
            break
        frames += wild
        data = data.without_frames(wild)
        fit = _robust(data, fit_campaign(data, fit.theory))
    kept, rest = np.ones(len(data.shots), dtype=np.bool_), data
    far: dict[int, float] = {}
    for _ in range(ROUNDS):
        bad = bad_shots(fit, int((~kept).sum()))
        if not bad.any():
            break
        quality = _quality(fit)[0]
        far |= dict(zip(rest.shots[bad].tolist(), quality[bad] / np.median(quality), strict=True))
        kept[np.flatnonzero(kept)[bad]] = False
        rest = data.of_shots(kept)
        left = replace(fit, parts=states_of_shots(rest, fit, ~bad))
        fit = fit_campaign(rest, fit.theory, left)
    names = {int(n) for n in rest.shots}
    # Now that the law is known: near its corner a shot may have begun on the wrong side.
    fits = [fit_afresh(rest, fit)]
    if rest is whole:
        fits.append(first)
    elif len(rest.shots) <= FEW and not fit.theory.active:
        fits.append(fit_campaign(rest))
    fit = min(fits, key=lambda one: one.chi2)
    return Cleaned(rest, fit, kept, tuple(f for f in frames if f[0] in names), far)


def bad_shots(fit: FitSummary, gone: int = 0) -> NDArray[np.bool_]:
    """Return which shots lie too far from the model, by chi-squared against their own, shape (S,).

    Wilson-Hilferty normal deviate of chi-squared per degree of freedom, in units of the campaign's
    median.

    Parameters
    ----------
    gone
        Shots dropped before: they count in the share that makes it physics, which would otherwise
        be taken out a few at a time.
    """
    quality, freedom = _quality(fit)
    if len(quality) < FEWEST:
        return np.zeros(len(quality), dtype=np.bool_)
    ratio = quality / np.median(quality)
    spread = 2 / (9 * freedom)
    deviate = (np.cbrt(ratio) - (1 - spread)) / np.sqrt(spread)
    bad = deviate > -ndtri(ALARM_SHARE / len(quality))
    if bad.sum() + gone > PHYSICS_SHARE * (len(bad) + gone):
        low, high = np.quantile(quality, [0.25, 0.75])
        bad = quality > high + FAR_OUT * (high - low)
    return np.asarray(bad)


def _quality(fit: FitSummary) -> tuple[Floats, Floats]:
    freedom = np.maximum(fit.shot_residuals - fit.nuisance_count, 1.0)
    return fit.shot_chi2 / freedom, freedom


def _robust(data: CampaignData, first: Fit) -> Fit:
    """Fit with bad shots held down, then each shot's own numbers and quality as stated."""
    weight = robust_weight(first)
    if (weight == 1.0).all():
        return first
    fit = fit_campaign(data.held_down(weight), first.theory, first)
    return replace(fit, shot_chi2=fit.shot_chi2 / weight**2)


def robust_weight(fit: FitSummary) -> Floats:
    """Return by what to divide the sigmas of each shot so that a bad one cannot move the law, (S,).

    The squares are weighed by min(1, 1.5 median / quality)^2: otherwise every good shot looks bad.
    """
    quality, _ = _quality(fit)
    return np.asarray(np.minimum(1.0, 1.5 * np.median(quality) / quality))


def _wild(data: PoseData | PoseStream, fit: Fit) -> list[Frame]:
    """Return the worst frame of each bad shot, where it stands out."""
    bad = bad_shots(fit)
    if not bad.any():
        return []
    found, start = list[Frame](), 0
    for part, states in zip(data.parts(), fit.parts, strict=True):
        own = bad[start : start + part.count]
        start += part.count
        if own.any():
            wild = wild_frames(part, states, fit.theory, own)
            found += [(int(part.shots[s]), int(k)) for s, k in np.argwhere(wild)]
    return found


def wild_frames(
    data: PoseData, states: ShotStates, theory: Theory, bad: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return the worst frame of each bad shot, mask of shape (S,), where it stands out, (S, F)."""
    residual = whitened_residual(data, predict(data, states, theory))
    squares = (residual.reshape(*data.times_s.shape, 12) ** 2).sum(axis=2)
    used = np.asarray(data.measured.any(axis=(2, 3)))
    wild = np.zeros(used.shape, dtype=np.bool_)
    for s in np.flatnonzero(bad):
        frames = np.flatnonzero(used[s])
        order = frames[np.argsort(squares[s, frames])]
        worst, following = squares[s, order[-1]], squares[s, order[-2]]
        stands_out = worst > WILD_AGAINST_MEDIAN * np.median(squares[s, frames])
        if worst > WILD_FRAME and stands_out and worst > WILD_AGAINST_NEXT * following:
            wild[s, order[-1]] = True
    return wild
