"""What the choices of a fit do to places: radius and light of the ball."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from analysis.arrays import Floats
from analysis.balls.flight.flights import Flights
from analysis.balls.seen.arcs import Arc
from analysis.balls.seen.looks import Looks
from analysis.balls.seen.placing import Placed, Placer
from analysis.balls.seen.windows import Motion, Window

RADIUS_STEP = 0.004
"""Of the radius: places follow it in proportion so far."""
OUTLINE_STEP = 0.02
"""The same for a ball with patches, whose places are found less closely."""
MOST_SIZE = 0.1
"""A size that is further off is that of something else."""
MOST_OFF = 2.5
OFF = np.linspace(-MOST_OFF, MOST_OFF, 401)
BY_PARABOLA = math.sqrt(math.pi) * erf(0.5 * OFF) * np.exp(0.25 * OFF**2)
"""In blurs of the rim: how far off it lies, and what a parabola through three sums of squares makes
of that."""
NEIGHBOURS = 3
"""Frames before and after one with which its shift is taken together."""
LEAST_SQUARE = 1e-12
MOST_BY_RADIUS = 2.0
"""Of the radius's change: a place whose rim is seen on one side alone moves by about 1 of it."""
LIGHT = 2
"""Which of the shifts is that by all of the ball's light."""
LEAST_RIMS, MOST_RIM_SCATTER, RIM_SIGMA = 5, 0.02, 0.0015
"""Rims that say where a ball is; how far they scatter beside its flights at most, and the least
error of their middle, of the radius."""
CLEAR_SHIFT, MOST_SHIFT = 3.0, 0.5
"""In scatters: rims that lie further off scatter with the places, which are then wrong. In radii:
what lies further off is not the ball's rim; the first places of a ball that is lit from one side
lie a third of its radius off."""
OF_SIZE = 0.3
"""Of what a wrong radius moves all places by: what is left of it once they lie at the rims."""
MOST_BY_LIGHT = 0.03
"""Of the radius: a smooth shading that is further off than that has lost the rim."""


@dataclass(frozen=True, slots=True, eq=False)
class ByRadius:
    """What another radius of the ball would do to each frame's fit.

    Attributes
    ----------
    frames
        Shape (N,).
    shifts
        By how much places move, px by a relative change of the radius, shape (N, 2).
    sizes
        How much larger the ball is seen than the radius, relative, and the standard error of it by
        the noise of pixels, shape (N, 2); nan where a frame shows none.
    """

    frames: NDArray[np.intp]
    shifts: Floats
    sizes: Floats

    def of(self, frames: NDArray[np.intp]) -> ByRadius:
        """Return the same of some frames: no shifts and no sizes in those that are not known."""
        _, own, theirs = np.intersect1d(frames, self.frames, return_indices=True)
        shifts, sizes = np.zeros((len(frames), 2)), np.full((len(frames), 2), np.nan)
        shifts[own], sizes[own] = self.shifts[theirs], self.sizes[theirs]
        return ByRadius(frames, shifts, sizes)


def by_radius(
    placer: Placer, seen: tuple[Sequence[Window], Motion, float], placed: Placed
) -> ByRadius:
    """Return how places move with the ball's radius, and which radius each frame shows.

    A radius moves the rim's darker side less than the brighter one. The radius that leaves the
    least of a frame's light is that of its own shading too, but the same in all frames: what
    changes of it from frame to frame is the ball's size.

    Parameters
    ----------
    seen
        Windows, where the ball is in them, and the time from row to row.
    placed
        Places with the radius as it is.
    """
    radius = placer.radius_px
    step = OUTLINE_STEP if placer.patched else RADIUS_STEP
    placer.radius_px = (1.0 - step) * radius
    narrow = placer.place(*seen)
    placer.radius_px = (1.0 + step) * radius
    wide = placer.place(*seen)
    placer.radius_px = radius
    moved = _moved(placed.frames, placed.places, wide) - _moved(
        placed.frames, placed.places, narrow
    )
    both = np.isin(placed.frames, np.intersect1d(narrow.frames, wide.frames))
    moved = np.where(both[:, None], moved, 0.0) / (2.0 * step)
    shifts = _at_most(moved, MOST_BY_RADIUS * radius)
    if placer.patched:
        # Patches at the rim give each frame a lean of its own, and hide how large the ball is.
        return ByRadius(placed.frames, shifts, np.full((len(shifts), 2), np.nan))
    sizes = _sizes(narrow, placed, wide, placer.blur_px / radius)
    sizes[:, 0] += placed.larger
    return ByRadius(placed.frames, _smooth(shifts), sizes)


def _sizes(narrow: Placed, placed: Placed, wide: Placed, blur: float) -> Floats:
    """Return by which radius the sum of squares that fits leave is least; shape (N, 2).

    An edge that is blurred by b and lies off by u b leaves squares whose slope goes with erf(u / 2)
    and whose curve goes with exp(-u^2 / 4): a parabola is right near its bottom only.

    Parameters
    ----------
    blur
        Of the rim, in radii.
    """
    low, high = (
        placed.left + _change(placed.frames, placed.left, other) for other in (narrow, wide)
    )
    curve = (high + low - 2.0 * placed.left) / RADIUS_STEP**2
    with np.errstate(divide="ignore", invalid="ignore"):
        size = blur * np.interp((low - high) / (2.0 * RADIUS_STEP * blur) / curve, BY_PARABOLA, OFF)
        sigma = np.sqrt(2.0 * placed.misfits / curve)
    shown = (curve > 0.0) & (np.abs(size) < min(MOST_SIZE, MOST_OFF * blur)) & (sigma > 0.0)
    return np.where(shown[:, None], np.column_stack([size, sigma]), np.nan)


def _smooth(moved: Floats) -> Floats:
    """Return means over neighbouring frames, less the share of them that is noise.

    The noise of the pixels that moves a place moves its lean too: a fit that is free to take the
    one with the other would take noise for a radius.
    """
    width = min(2 * NEIGHBOURS + 1, len(moved))
    counts = np.convolve(np.ones(len(moved)), np.ones(width), "same")
    smooth = np.empty_like(moved)
    for axis, own in enumerate(moved.T):
        noise = float((np.diff(own) ** 2).mean()) / (2 * width) if width > 1 else 0.0
        mean = np.convolve(own, np.ones(width), "same") / counts
        size = max(float((mean**2).mean()), LEAST_SQUARE)
        smooth[:, axis] = max(0.0, 1.0 - noise / size) * mean
    return smooth


CURVE, STRAIGHT = 5, 3
"""Terms of a flight's rows, which the air and the camera bend, and of its columns."""
CURVE_ROUNDS, OFF_CURVE = 3, 4.5
"""Of a curve with places far off it left out; scatters from it on which that is."""


def of_one_flight(
    placer: Placer,
    seen: tuple[Sequence[Window], Motion],
    placed: Placed,
    found: tuple[Looks, Sequence[Arc], Floats],
) -> tuple[Looks, Placed, Floats]:
    """Return the looks and places of a ball whose film has no bounce, and the scatter of these.

    No flights are fitted, which would tell how far places lie from them: what radius and light of
    the ball do to places is measured all the same, and the scatter is that about a smooth curve.

    Parameters
    ----------
    found
        Its looks, the arcs that it flies, and the times of the film's frames, s.

    Returns
    -------
    Looks with the radius's error of a ball that is lit from one side; places with all that is not
    known of them; their standard errors beside one another, px, shape (N, 2).
    """
    looks, arcs, times_s = found
    if not len(placed.frames):
        return looks, placed, placed.sigmas
    of_radius = by_radius(placer, (*seen, 0.0), placed)
    looks = looks.leaning(of_radius.shifts)
    placer.learn_light(*seen)
    by_light = _moved(placed.frames, placed.places, placer.place(*seen))
    by_light = _at_most(by_light, MOST_BY_LIGHT * looks.radius_px)
    by_size = of_radius.shifts * looks.radius_sigma_px / looks.radius_px
    scatter = placed.sigmas.copy()
    for arc in arcs:
        own = np.isin(placed.frames, arc.frames)
        scatter[own] *= _about_a_curve(placed.of(own), times_s)
    whole = np.sqrt(scatter**2 + by_size**2 + by_light**2)
    return looks, replace(placed, sigmas=whole), scatter


def _about_a_curve(placed: Placed, times_s: Floats) -> Floats:
    """Return by how much places scatter more than stated about a smooth curve, shape (N, 2).

    A place far off it is as uncertain as that.
    """
    larger = np.ones((len(placed.frames), 2))
    gone = times_s[placed.frames]
    for axis, terms in enumerate((CURVE, STRAIGHT)):
        if len(gone) <= terms:
            continue
        design = np.vander(np.interp(gone, (gone[0], gone[-1]), (-1.0, 1.0)), terms)
        weights = 1.0 / placed.sigmas[:, axis]
        scaled = placed.places[:, axis] * weights
        left, size, used = scaled, 1.0, np.ones(len(gone), dtype=bool)
        for _ in range(CURVE_ROUNDS):
            rows = (design * weights[:, None])[used]
            left = scaled - weights * (design @ np.linalg.lstsq(rows, scaled[used], rcond=None)[0])
            freedom = max(1, int(used.sum()) - terms)
            spread = float(np.median(np.abs(left[used])))
            size = max(1.0, 1.4826 * spread * (used.sum() / freedom) ** 0.5)
            used = np.abs(left) < OFF_CURVE * size
            if used.sum() <= terms:
                break
        larger[:, axis] = np.where(used, size, np.maximum(size, np.abs(left)))
    return larger


@dataclass(frozen=True, slots=True, eq=False)
class RimsOff:
    """By how much rims lie beside places that were fitted to all of a ball's light, px, shape (2,).

    Attributes
    ----------
    shift
        In the middle of some frames.
    sigma
        Its standard error: rims of one film err alike, so that many are no surer than one.
    """

    shift: Floats
    sigma: Floats


def rims_off(looks: Looks, motion: Motion) -> RimsOff | None:
    """Return by how much rims lie beside the places of a motion; None where that is not clear.

    A ball that is lit from one side fades into the ground, and a smooth shading moves it towards
    the light. Its rim does not move: where it was found, it is sought by its sharpness. A rim that
    is hidden or smeared lies off by itself.
    """
    where = {int(frame): place for frame, place in zip(motion.frames, motion.places, strict=True)}
    off = np.array(
        [(disc.row, disc.column) - where[frame] for frame, disc in looks.seen if frame in where]
    )
    if len(off) < LEAST_RIMS:
        return None
    shift = np.median(off, axis=0)
    scatter = 1.4826 * np.median(np.abs(off - shift), axis=0)
    far = math.hypot(*shift)
    clear = max(MOST_RIM_SCATTER * looks.radius_px, far / CLEAR_SHIFT)
    if scatter.max() > clear or far > MOST_SHIFT * looks.radius_px:
        return None
    return RimsOff(shift, np.hypot(scatter, RIM_SIGMA * looks.radius_px))


def shifts(
    looks: Looks,
    taught: tuple[Placed, Placed, Placed],
    flights: Flights,
    by_rims: RimsOff | None,
) -> Floats:
    """Return by how much each place moves with the ball's radius and with its light.

    A smooth shading alone takes part of a limb's fading for the rim. Radius and light move all
    places of a film in much the same way, which no scatter about flights tells.

    Parameters
    ----------
    taught
        Places fitted before the film had taught the ball's light, before it taught that last, and
        with all that it taught.
    by_rims
        Where the light was learned where the ball's rims are; else None.

    Returns
    -------
    By the radius, by what was taught last, and by the light, of each observed place, px; shape
    (3, N, 2).
    """
    placed = flights.observed
    leans = np.zeros_like(placed.places) if placed.leans is None else placed.leans
    bare, earlier, last = taught
    by_last = _moved(last.frames, last.places, earlier)[np.isin(last.frames, placed.frames)]
    most = MOST_BY_LIGHT * looks.radius_px
    if by_rims is None:
        by_light = _at_most(_moved(placed.frames, placed.places, bare), most)
    else:
        by_light = np.broadcast_to(by_rims.sigma, placed.places.shape)
    by_size = leans * max(looks.radius_sigma_px / looks.radius_px, flights.disagreement)
    if by_rims is not None:
        by_size -= (1.0 - OF_SIZE) * np.median(by_size, axis=0)
    return np.stack([by_size, _at_most(by_last, most), by_light])


def _change(frames: NDArray[np.intp], left: Floats, other: Placed) -> Floats:
    """Return what another fit leaves less what these leave; nan where it has no such frame."""
    _, own, theirs = np.intersect1d(frames, other.frames, return_indices=True)
    change = np.full(len(frames), np.nan)
    change[own] = other.left[theirs] - left[own]
    return change


def _at_most(moved: Floats, most: float) -> Floats:
    """Return shifts no longer than this: a fit that jumps says nothing of the others."""
    size = np.maximum(np.hypot(*moved.T), 1e-12)[:, None]
    return np.asarray(moved * np.minimum(1.0, most / size))


def _moved(frames: NDArray[np.intp], places: Floats, other: Placed) -> Floats:
    """Return another fit's places less these; those that it lacks have not moved."""
    _, own, theirs = np.intersect1d(frames, other.frames, return_indices=True)
    moved = np.zeros_like(places)
    moved[own] = other.places[theirs] - places[own]
    return moved


def whole_sigmas(flights: Flights, moved: Floats) -> Floats:
    """Return standard errors of places: scatter about the flights and what moves all alike.

    What the fit took out of places has the errors of its numbers.
    """
    taken = _variances(flights.taken_slopes, flights.covariance)
    return np.asarray(np.sqrt(flights.scatter**2 + taken + (moved**2).sum(axis=0)))


def apart_sigmas(flights: Flights, moved: Floats) -> Floats:
    """Return standard errors of places beside one another: without a shift and a scale of all.

    Radius, outlines, smears and a light that is not learned to its end bend a row of places; what
    of that a shift of all and a change in proportion to row and column would do is left out.
    """
    bends = np.concatenate([flights.taken_slopes, moved[:LIGHT].transpose(1, 2, 0)], axis=2)
    design = np.column_stack([np.ones(len(bends)), flights.observed.places])
    for axis in range(2):
        weights = 1.0 / flights.scatter[:, axis, None]
        alike = np.linalg.lstsq(weights * design, weights * bends[:, axis], rcond=None)[0]
        bends[:, axis] -= design @ alike
    taken = _variances(bends[..., :-LIGHT], flights.covariance)
    own = (bends[..., -LIGHT:] ** 2).sum(axis=2)
    return np.asarray(np.sqrt(flights.scatter**2 + taken + own))


def _variances(slopes: Floats, covariance: Floats) -> Floats:
    """Return variances of places that depend on numbers with errors, shape (N, 2)."""
    return np.asarray(np.einsum("nap,pq,naq->na", slopes, covariance, slopes))
