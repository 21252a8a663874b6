"""Pulls of single frames, and of a line through the frames of each flight."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.motion.drift import Drift
from benchmarks.tracks.flights import Flight

Floats = NDArray[np.float64]

LEAST_FRAMES = 6
BEYOND = 5.0


def line(times_s: Floats, errors: Floats, sigmas: Floats, drift: Drift) -> tuple[Floats, Floats]:
    """Return offset at the mean time and slope of what was measured too much, with covariance."""
    tau = times_s - times_s.mean()
    design = np.stack([np.ones_like(tau), tau], axis=1)
    weight = np.linalg.inv(np.diag(sigmas**2) + drift.covariance(times_s))
    inverse = np.linalg.inv(design.T @ weight @ design)
    return inverse @ design.T @ weight @ errors, inverse


def pulls(flights: Sequence[Flight], what: str, axis: int) -> dict[str, Floats]:
    """Return for one axis of `place` or `turn` the pulls of all flights.

    `frame`: single frames against stated error, fresh and slow together; `scatter`: about the
    flight's own line, over the fresh error; `offset`, `slope`: of the line; `offset_um` and
    `slope_mm_s`: the same in um and mm/s (mrad and rad/s).
    """
    found: dict[str, list[float]] = {
        k: [] for k in ("frame", "scatter", "offset", "slope", "raw_offset", "raw_slope")
    }
    for flight in flights:
        if what == "place":
            times, errors = flight.times_s, flight.place_errors[:, axis]
            sigmas, drift = flight.place_sigmas[:, axis], flight.place_drift[axis]
        else:
            times, errors = flight.turn_times_s, flight.turns[:, axis]
            sigmas, drift = flight.turn_sigmas[:, axis], flight.turn_drift
        seen = np.isfinite(sigmas)
        times, errors, sigmas = times[seen], errors[seen], sigmas[seen]
        found["frame"].extend(errors / np.hypot(sigmas, drift.sigma))
        if len(times) < LEAST_FRAMES:
            continue
        state, inverse = line(times, errors, sigmas, drift)
        found["raw_offset"].append(state[0])
        found["raw_slope"].append(state[1])
        found["offset"].append(state[0] / np.sqrt(inverse[0, 0]))
        found["slope"].append(state[1] / np.sqrt(inverse[1, 1]))
        plain, _ = line(times, errors, sigmas, Drift(0.0, 1.0))
        left = (errors - plain[0] - plain[1] * (times - times.mean())) / sigmas
        found["scatter"].extend(left * np.sqrt(len(times) / (len(times) - 2)))
    return {name: np.array(values) for name, values in found.items()}


def slow_size(flights: Sequence[Flight], what: str, axis: int) -> float:
    """Return the slow error that the true errors of flights have most likely, m or rad.

    With its stated correlation time, and without the mean over all flights, which the campaign has
    in common.
    """
    parts = []
    for flight in flights:
        placed = what == "place"
        times = flight.times_s if placed else flight.turn_times_s
        errors = (flight.place_errors if placed else flight.turns)[:, axis]
        sigmas = (flight.place_sigmas if placed else flight.turn_sigmas)[:, axis]
        seen = np.isfinite(sigmas) & np.isfinite(errors)
        lasting_s = (flight.place_drift[axis] if placed else flight.turn_drift).correlation_time_s
        parts.append((times[seen], errors[seen], sigmas[seen], lasting_s))
    weights = np.concatenate([sigmas**-2.0 for _, _, sigmas, _ in parts])
    mean = float(np.average(np.concatenate([own for _, own, _, _ in parts]), weights=weights))
    stated = flights[0].place_drift[axis] if what == "place" else flights[0].turn_drift
    sizes = stated.sigma * np.geomspace(0.1, 10.0, 41)
    likely = np.zeros(len(sizes))
    for times, errors, sigmas, lasting_s in parts:
        white = Drift(1.0, lasting_s).covariance(times) / np.outer(sigmas, sigmas)
        gains, turn = np.linalg.eigh(white)
        squares = (turn.T @ ((errors - mean) / sigmas)) ** 2
        variance = 1.0 + np.multiply.outer(sizes**2, np.maximum(gains, 0.0))
        likely -= 0.5 * (np.log(variance) + squares / variance).sum(axis=1)
    return float(sizes[likely.argmax()])


def rms(values: Floats) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2))) if values.size else float("nan")
