"""Fitting a campaign of any length."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.model.data.parts import Kept
from analysis.model.data.poses import PoseData
from analysis.model.data.unseen import fitted_numbers
from analysis.model.fitting.fit import START, likeliest, starting_theories
from analysis.model.fitting.gauss_newton import (
    TO_THE_END,
    Purpose,
    Stand,
    descended,
    linearised,
    summed,
)
from analysis.model.fitting.normal import inverse
from analysis.model.fitting.own_fit import own_states
from analysis.model.fitting.passes import Passes
from analysis.model.fitting.summary import FitSummary
from analysis.model.predict.start import first_states
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import LAW, Theory
from analysis.model.streaming.spool import Spool
from analysis.model.streaming.stream import PoseStream
from analysis.quantity import Quantity


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class StreamedFit(FitSummary):
    """A campaign fitted in parts.

    Attributes
    ----------
    stands
        The shots' own numbers, part by part.
    """

    stands: Kept[Stand]

    def states(self, kept: NDArray[np.bool_] | None = None) -> Iterator[ShotStates]:
        """Return the shots' own numbers part by part, none without a shot.

        Parameters
        ----------
        kept
            Mask of the shots that are wanted, shape (S,); None: all.
        """
        start = 0
        for stand in self.stands:
            own = slice(start, start + len(stand.chi2))
            start = own.stop
            if kept is None:
                yield stand.states
            elif kept[own].any():
                yield stand.states.of_shots(kept[own])


def fit_stream(
    stream: PoseStream,
    theory: Theory | None = None,
    states: Iterable[ShotStates] | None = None,
    *,
    scatter: Mapping[str, Quantity] | None = None,
    purpose: Purpose = TO_THE_END,
) -> StreamedFit:
    """Fit what all shots share together with every shot's own numbers, as `fit_campaign`.

    Parameters
    ----------
    theory
        Law and effects to start from; None: the hard-sphere operator alone.
    states
        Of the shots of each part, where they start; None: each shot is first fitted by itself.
    scatter
        Parameters of noise that the stream was given besides its sigmas.
    purpose
        How far it is to be followed.

    Raises
    ------
    OSError
        The temporary folder is full.
    """
    if theory is None and states is None:
        begun = starting_theories(len(stream.shots), next(iter(stream)).systematics)
        return likeliest([fit_stream(stream, one) for one in begun])
    present = Theory(START, next(iter(stream)).systematics) if theory is None else theory
    if states is None:
        states = (own_states(part, first_states(part), present) for part in stream)
    parts = (summed(*part, present) for part in zip(stream, states, strict=True))
    measured, own = _counts(stream)
    freedom = np.maximum(measured - own, 1.0)
    last, converged = descended(stream, linearised(parts, present, Spool), Spool, freedom, purpose)
    chi2 = np.concatenate([stand.chi2 for stand in last.stands])
    return StreamedFit(
        theory=last.theory,
        stands=last.stands,
        covariance=inverse(last.matrix),
        chi2=float(chi2.sum()) + last.theory.strain,
        residuals=int(measured.sum()) + last.theory.given - len(LAW),
        shot_chi2=chi2,
        shot_residuals=measured,
        own_numbers=own,
        converged=converged,
        scatter=scatter if scatter is not None and stream.jitter_s > 0 else {},
    )


def passes_of_stream(stream: PoseStream, fit: StreamedFit) -> Passes:
    """Return the passes over a stream and its fit."""

    def parts() -> Iterator[tuple[PoseData, ShotStates]]:
        return zip(stream, fit.states(), strict=True)

    return Passes(stream.shots, stream.jitter_s, fit, parts, Spool)


def _counts(stream: PoseStream) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the measured numbers of each shot, and how many of its own they determine, (S,)."""
    measured, own = [], []
    for part in stream:
        measured.append(part.measured.reshape(len(part.shots), -1).sum(axis=1))
        own.append(fitted_numbers(part))
    return np.concatenate(measured), np.concatenate(own)
