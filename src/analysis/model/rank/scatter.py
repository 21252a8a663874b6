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
from analysis.quantity import Quantity

POWERS = (2, 3, 4, 5, 6)
"""Of the time from the middle of a flight: the sixth is a cube of the height."""
SIDES, AXES = 2, 3


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
        flight = about_free_flight(line, _bows(data, line.slopes))
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


def _bows(data: PoseData, slopes: Floats) -> Floats:
    """Return whitened bows of flights that slow errors bend, along each axis, (S, 4, 3 F, K).

    Places of a filmed ball share what its camera leaves open: a lens, a line of sight, an outline.
    Such errors are squares and cubes of the height over the plate, which is a parabola of the time,
    and are many times as large as the scatter from frame to frame. What changes as slowly says
    nothing of whether frames were taken on time.

    K is 0 but for a ball on a plate whose slow errors are stated: flights of marked spheres have
    too few frames to tell a bow from a jitter.

    Parameters
    ----------
    slopes
        Of the prediction by the numbers of the flights, shape (S, 4, 3 F, 12): place and rate
        before the contact, then after it.
    """
    shots, blocks, length, _ = slopes.shape
    if not data.on_plate or data.slow.position_m <= 0.0:
        return np.zeros((shots, blocks, length, 0))
    times = np.repeat(data.times_s, AXES, axis=1)[:, None]
    axis = np.arange(length) % AXES
    found = []
    for side in range(SIDES):
        place = slopes[..., 6 * side : 6 * side + AXES]
        weight = np.sqrt((place**2).sum(axis=3))
        seen = weight > 0
        told = seen.any(axis=2, keepdims=True)
        first = np.where(told, np.where(seen, times, np.inf).min(axis=2, keepdims=True), 0.0)
        last = np.where(told, np.where(seen, times, -np.inf).max(axis=2, keepdims=True), 0.0)
        half = np.maximum(0.5 * (last - first), np.finfo(float).tiny)
        inside = np.where(seen, np.where(seen, times - 0.5 * (first + last), 0.0) / half, 0.0)
        found += [
            weight * inside**power * (axis == along) for power in POWERS for along in range(AXES)
        ]
    return np.stack(found, axis=3)
