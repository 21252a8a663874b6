"""What a sphere moves and turns by while the shutter is open, and the instants that render it.

The image of an exposure is the mean over its instants. Three of them, at the nodes of C. F. Gauss's
quadrature, have the moments of a uniform motion up to the fifth: with a blur of a pixel they stand
for a smear of some four. What is learned of the blur is round and holds the mean of all smears that
the frames show; `sharpened` takes that out again.
"""

from __future__ import annotations

import math

import numpy as np

from analysis.arrays import Floats
from analysis.compiled import compiled, part
from analysis.motion.turning import turn_between, turned
from analysis.photometric.render.camera import Optics
from analysis.photometric.render.sight import Sight, Stance

LEAST_SMEAR_PX = 1.0
"""A shorter one differs from a round blur by less than half a grey level."""
NODE, MIDDLE = math.sqrt(0.15), 4.0 / 9.0
"""The outer instants before and after the middle one, in exposures; the middle one's weight."""


@part
def instants_of(sight: Sight) -> int:
    """Return how many instants render the exposure: one where no motion is known."""
    for k in range(sight.motion.size):
        if sight.motion[k] != 0.0:
            return 3
    return 1


@part
def at_instant(sight: Sight, stance: Stance, instant: int) -> Stance:
    """Return the stance in the middle of an exposure (0), before it (1) or after it (2)."""
    share = 0.0 if instant == 0 else (NODE if instant == 2 else -NODE)
    moved = share * sight.motion
    return Stance(stance.centre + moved[:3], turned(moved[3:], stance.rotation), stance.lights)


@compiled
def motion_through(times_s: Floats, centres: Floats, rotations: Floats, motion: Floats) -> None:
    """Fill what a sphere moves and turns by in a second, m and rad, at each of its frames.

    From the frame before or the one behind, whichever goes on more evenly: no frame next to a
    contact looks across it.

    Parameters
    ----------
    times_s, centres, rotations
        Of frames in the order of time, shapes (n,), (n, 3) and (n, 3, 3).
    motion
        Shape (n, 6); left as it is where there is one frame only.
    """
    steps = max(times_s.size - 1, 0)
    rates, uneven = np.zeros((steps, 6)), np.full(steps + 1, np.inf)
    for k in range(steps):
        gap = times_s[k + 1] - times_s[k]
        turn = turn_between(rotations[k], rotations[k + 1])
        for a in range(3):
            rates[k, a] = (centres[k + 1, a] - centres[k, a]) / gap
            rates[k, 3 + a] = turn[a] / gap
    for k in range(1, steps):
        uneven[k] = 0.0
        for a in range(3):
            uneven[k] += (rates[k, a] - rates[k - 1, a]) ** 2
    for k in range(times_s.size if steps else 0):
        # The next step but one bounds the step behind a frame, the last but one that before it.
        behind = uneven[k + 1] if k < steps else np.inf
        before = uneven[k - 1] if k > 0 else np.inf
        step = k if behind < before or k == 0 else k - 1
        for a in range(6):
            motion[k, a] = rates[min(step, steps - 1), a]


def longest_smear(optics: Optics, motion: Floats, radius_m: float) -> float:
    """Return the longest way of a sphere's surface during the exposures of some frames, pixels."""
    ways = np.linalg.norm(motion[..., :3], axis=-1)
    turns = np.linalg.norm(motion[..., 3:], axis=-1)
    return float(optics.scales.max() * (ways + radius_m * turns).max(initial=0.0))


def round_variance(optics: Optics, motion: Floats) -> Floats:
    """Return the variance that the smears of some frames add to a round blur, px^2, shape (V,).

    A uniform motion has a twelfth of its length's square along it, and nothing across.

    Parameters
    ----------
    motion
        While the shutter is open, shape (frames, 6).
    """
    if not len(motion):
        return np.zeros(len(optics.scales))
    seen = np.einsum("vak,fk->vfa", optics.axes[:, :2], motion[:, :3])
    length2 = (seen**2).sum(axis=2) * optics.scales[:, None] ** 2
    return np.asarray(length2.mean(axis=1) / 24)
