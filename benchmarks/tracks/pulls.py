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


def rms(values: Floats) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2))) if values.size else float("nan")
