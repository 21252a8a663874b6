"""What an accuracy run says of a camera: how well it tells places, speeds, angles and spins."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from analysis.qualification.depth import BothWays, typical_errors
from analysis.qualification.disk import Turn
from analysis.qualification.drop import Gravity
from analysis.qualification.stage import StageErrors

FLIGHT = 10
"""Frames of a flight before or after a contact, over which speeds and spins are stated."""

WRONG_STEP = 0.05
"""Relative: steps of a stage that are further off than that are stated wrongly."""
METHODS_APART = 0.05
"""Relative; edges and grey levels differ by a per cent where a sphere is shaded."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a camera is good for: a sentence, and its numbers by names that end in their units."""

    sentence: str
    numbers: dict[str, float]


def slope_sigma(sigma: float, interval: float, count: int = FLIGHT) -> float:
    """Return the standard error of a straight line's slope through equally spaced points.

    sigma sqrt(12 / (n (n^2 - 1))) / interval, for independent errors of size sigma.
    """
    return sigma * math.sqrt(12.0 / (count * (count**2 - 1))) / interval


def of_stage(results: Sequence[StageErrors]) -> Verdict:
    """Judge by the best way of finding centres, in its worst direction."""
    ways = dict.fromkeys(result.way for result in results)
    worst = {way: max(r.rms_px for r in results if r.way == way) for way in ways}
    best = min(worst, key=lambda way: worst[way])
    own = [result for result in results if result.way == best]
    largest = max(result.largest_px for result in own)
    share = max((result.way_share for result in own), key=lambda each: abs(each - 1.0))
    sentence = (
        f"Centres of this sphere are good to {worst[best]:.3f} px rms, {largest:.3f} px at most, "
        f"by {best}."
    )
    if abs(share - 1.0) > WRONG_STEP:
        sentence += (
            f" But the sphere moved by {share:.3f} of the steps that are stated: correct the step "
            "or the scale, or these are no errors of centres."
        )
    numbers = {"centre_rms_px": worst[best], "centre_largest_px": largest, "way_share": share}
    return Verdict(sentence, numbers)


def of_drop(found: Gravity, others: Sequence[Gravity] = ()) -> Verdict:
    """Judge by what is left of the parabolas, and by gravity against the true one.

    Parameters
    ----------
    others
        The same falls by other methods: where they differ by much, the sphere is not what the
        methods take it for.
    """
    left = [f.rows_px - np.polyval(f.parabola, f.times_s) for f in found.falls]
    # A parabola takes three freedoms of each fall.
    free = sum(max(len(own) - 3, 1) for own in left)
    row_px = math.sqrt(sum(float(own @ own) for own in left) / free)
    interval = float(np.median(np.diff(found.falls[0].times_s)))
    speed = slope_sigma(row_px / found.scale_px_per_m, interval)
    numbers = {
        "place_sigma_m": row_px / found.scale_px_per_m,
        "place_sigma_px": row_px,
        "speed_sigma_m_per_s": speed,
        "speed_bias": found.bias,
    }
    sentence = (
        f"Places scatter by {row_px:.3f} px ({1e6 * numbers['place_sigma_m']:.0f} µm): a speed "
        f"from {FLIGHT} frames is good to {1e3 * speed:.2g} mm/s. Gravity is "
        f"{100 * found.bias:+.2f} % off: scale and frame rate together make speeds at most that "
        "wrong, and leave e alone."
    )
    apart = max((abs(other.mean / found.mean - 1.0) for other in others), default=0.0)
    if apart > METHODS_APART:
        sentence += (
            f" But the methods differ by {100 * apart:.0f} %: do not trust the scale; the sphere "
            "must be plain, without markers, and evenly lit."
        )
    return Verdict(sentence, numbers)


def of_disk(turns: Sequence[Turn], frame_rate_hz: float | None = None) -> Verdict:
    """Judge by the scatter of angles between neighbouring frames, and by the longest turn's mean.

    Parameters
    ----------
    frame_rate_hz
        None: spins are not stated.
    """
    # An angle between two frames has the errors of both.
    frame_deg = turns[0].deviation / math.sqrt(2.0)
    numbers = {"angle_sigma_deg": frame_deg, "rate_bias": turns[-1].relative_error}
    sentence = f"A frame's angle is good to {frame_deg:.3f} degrees"
    if frame_rate_hz is not None:
        spin = slope_sigma(math.radians(frame_deg), 1.0 / frame_rate_hz)
        numbers["spin_sigma_rad_per_s"] = spin
        sentence += f", a spin from {FLIGHT} frames to {spin:.2g} rad/s"
    sentence += (
        f". The disk's rate comes out {100 * turns[-1].relative_error:+.3f} % off: so far do the "
        "camera's clock and the motor's meter agree."
    )
    return Verdict(sentence, numbers)


def of_depth(shots: Sequence[BothWays]) -> Verdict:
    """Judge by what a constant Z costs."""
    typical = {name: own[0] for name, own in typical_errors(shots).items()}
    return Verdict(
        f"Without the mirror v_n changes by {100 * typical['v_n']:.2f} %, e by "
        f"{100 * typical['e']:.2f} %, v_s by {100 * typical['v_s']:.2f} % (medians of "
        f"{len(shots)} shots).",
        {f"{name}_change": value for name, value in typical.items()},
    )
