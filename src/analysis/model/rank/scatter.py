"""Effects that are noise of their own: scored by the variance they add, not by a shift."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.arrays import Floats
from analysis.effects.clock.jitter_score import Directions, JitterScore, directions, score_of
from analysis.effects.effect import ScatterEffect
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import CampaignData, PoseStream
from analysis.model.data.tables import ContactTable, Data
from analysis.model.fitting.fit import Fit, fit_campaign, parts_of
from analysis.model.fitting.jitter import by_frame
from analysis.model.fitting.noise import about_free_flight
from analysis.model.predict.comparison import KINDS, Comparison, Snapshot, by_block, compare, rates
from analysis.model.rank.bows import bows
from analysis.quantity import Quantity


def timing_jitter(data: CampaignData, fit: Fit) -> JitterScore | None:
    """Test a fit for a time error that all numbers of a frame share; None: nothing could show.

    Judged by the scatter about free flight: a law of contact that is wrong shifts flights as a
    whole, and would pass for jitter, as would slow errors that bend a filmed ball's flights.
    """
    trial = JitterTrial(data)
    for part, states in parts_of(data, fit):
        trial.add(part, *compare(part, states, fit.theory))
    return trial.score()


class JitterTrial:
    """The test for a time error, part by part, beside whatever else a pass is for."""

    def __init__(self, data: CampaignData) -> None:
        self._found = data.keep(Directions)
        self._freedom = 0.0
        self._framed = True

    def add(self, data: Data, line: Comparison, here: Snapshot) -> None:
        """Take in the shots of a part; what has no frames can show no jitter."""
        if here.frames is None or isinstance(data, ContactTable):
            self._framed = False
            return
        flight = about_free_flight(line, bows(data, line.slopes))
        self._freedom += float(flight.share.sum())
        along = rates(data, here.frames.flown)
        residual = by_frame(flight.left[..., None]).reshape(along.shape)
        self._found.append(directions(residual, along, _kernel(along, flight.basis)))

    def score(self) -> JitterScore | None:
        """Return the score of all shots; None: nothing could show."""
        if not self._framed:
            return None
        try:
            return score_of(self._found, round(self._freedom))
        except ValueError:
            return None


def with_jitter(
    data: PoseData | PoseStream, fit: Fit, effect: ScatterEffect, size: float, sigma: float
) -> tuple[PoseData | PoseStream, Fit]:
    """Fit again with a jitter of some size, s, in the noise; the fit keeps it as a parameter."""
    parameter = effect.parameters[0]
    found = {f"{effect.name}.{parameter.symbol}": Quantity(size, sigma, parameter.unit)}
    jittered = replace(data, jitter_s=size)
    return jittered, fit_campaign(jittered, fit.theory, replace(fit, scatter=found))


def _kernel(along: Floats, basis: Floats) -> Floats:
    """Return D' P D, (S, F, F), from D's frames (S, F, 2, 6) and what was fitted (S, 4, 3 F, 12).

    D has a frame's numbers in that frame's column, so D'D is diagonal.
    """
    shots, frames = along.shape[:2]
    own = by_block(along).reshape(shots, KINDS, frames, 3)
    parted = basis.reshape(shots, KINDS, frames, 3, -1)
    coupling = np.einsum("skfa,skfap->skpf", own, parted).reshape(shots, -1, frames)
    kernel = -np.swapaxes(coupling, 1, 2) @ coupling
    index = np.arange(frames)
    kernel[:, index, index] += (along**2).sum(axis=(2, 3))
    return np.asarray(kernel)
