"""What all frames of a sphere share, solved with each frame's own unknowns eliminated.

Marker places, size, darkness, scales, shading.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.compiled import compiled, part
from analysis.photometric.learn.training_view import TrainingView, Viewed, drawn_for_bundle
from analysis.photometric.render.bands import BAND, LANES
from analysis.photometric.render.camera import Optics, by_nearness_and_shift
from analysis.photometric.render.pixel_rows import (
    BESIDE,
    MARKERS_SHARE,
    SCALE,
    SHADOW,
    VIEW_SHARE,
    WIDTH,
    add_squares,
    fill_rows,
    lay_pixels,
    pixels_of,
)
from analysis.photometric.render.pose import POSE, add_priors, into_world, inverse_of
from analysis.photometric.render.residual import UNKNOWNS
from analysis.photometric.render.shading import HARMONICS
from analysis.photometric.render.sight import LIGHTS, Equations, Sight, Stance

Places = NDArray[np.int64]


@part
def add_turns(
    drawn: Viewed,
    pixels: tuple[Places, Places],
    shadows: Floats,
    rows: Floats,
    sums: tuple[Floats, Floats],
) -> None:
    """Add products of the derivatives to turns of the markers, which few pixels see.

    Parameters
    ----------
    shadows
        Light that full cover takes from each pixel, over its error.
    sums
        Products with each other, shape (turns, turns), and with the rows, shape (turns, WIDTH).
    """
    corners, side, count = drawn.corners, drawn.patches.shape[1], rows.shape[0]
    changes, used = np.zeros((corners.shape[0], 2, count)), np.empty(count, np.int64)
    for m in range(corners.shape[0]):
        if corners[m, 0] > pixels[0][count - 1] or corners[m, 0] + side <= pixels[0][0]:
            continue
        found = turn_one(drawn, pixels, m, used, changes[m])
        for n in used[:found]:
            add_two(changes[m, :, n], rows[n], shadows[n], sums[1][2 * m : 2 * m + 2])
        for other in range(m + 1):
            if abs(corners[m, 0] - corners[other, 0]) >= side:
                continue
            for n in used[:found]:
                square = shadows[n] * shadows[n]
                for a in range(2):
                    for b in range(2):
                        product = square * changes[m, a, n] * changes[other, b, n]
                        sums[0][2 * m + a, 2 * other + b] += product


@part
def turn_one(
    drawn: Viewed, pixels: tuple[Places, Places], m: int, used: Places, changes: Floats
) -> int:
    """Find the pixels that see a marker, and how each of its two turns changes them.

    Parameters
    ----------
    used
        Filled with the indices of those pixels; how many is returned.
    changes
        Filled there, shape (2, pixels).
    """
    patch, tangents, side, found = drawn.patches[m], drawn.turns[m], drawn.patches.shape[1], 0
    for n in range(pixels[0].size):
        i, j = pixels[0][n] - drawn.corners[m, 0], pixels[1][n] - drawn.corners[m, 1]
        if i < 0 or j < 0 or i >= side or j >= side or patch[i, 0, j] == 0.0:
            continue
        for t in range(2):
            for k in range(3):
                changes[t, n] -= patch[i, 3 + k, j] * tangents[t, k]
        used[found] = n
        found += 1
    return found


@part
def add_two(changes: Floats, row: Floats, shadow: float, across: Floats) -> None:
    """Add a pixel's row times its changes by two turns."""
    first, second = shadow * changes[0], shadow * changes[1]
    for k in range(np.uint64(WIDTH)):
        across[0, k] += first * row[k]
        across[1, k] += second * row[k]


@part
def put_in_place(common: Floats, among: Floats, across: Floats, equations: Equations) -> None:
    """Add products to the equations, where the turns stand behind the frame's own unknowns.

    Parameters
    ----------
    common
        Of the rows with each other, shape (WIDTH, WIDTH).
    among, across
        Of `add_turns`.
    """
    turns, normal, right = among.shape[0], equations.normal, equations.right
    for a in range(WIDTH - 1):
        p = a if a < UNKNOWNS else a + turns
        right[p] += common[WIDTH - 1, a]
        for b in range(a + 1):
            normal[p, b if b < UNKNOWNS else b + turns] += common[a, b]
    for a in range(turns):
        p = UNKNOWNS + a
        right[p] += across[a, WIDTH - 1]
        for b in range(a + 1):
            normal[p, UNKNOWNS + b] += among[a, b]
        for b in range(UNKNOWNS):
            normal[p, b] += across[a, b]
        for b in range(UNKNOWNS, WIDTH - 1):
            normal[b + turns, p] += across[a, b]


@compiled
def bundle_view(
    sight: Sight, stance: Stance, view: int, training: TrainingView, equations: Equations
) -> None:
    """Add one view of one frame to the equations of its own and of the shared unknowns.

    Parameters
    ----------
    equations
        Of the view's UNKNOWNS, two turns of each marker, MARKERS_SHARE and the view's own
        VIEW_SHARE.
    """
    drawn = drawn_for_bundle(sight, stance, view, training)
    y, x = pixels_of(drawn, sight.optics.rows[view])
    turns = 2 * sight.look.markers.shape[0]
    common, among, across = (
        np.zeros((WIDTH, WIDTH)),
        np.zeros((turns, turns)),
        np.zeros((turns, WIDTH)),
    )
    lanes, wider, rows = (
        np.zeros((LANES + BESIDE, BAND)),
        np.zeros(LANES * BAND),
        np.zeros((BAND, WIDTH)),
    )
    for first in range(0, y.shape[0], BAND):
        pixels = y[first : first + BAND], x[first : first + BAND]
        own = rows[: pixels[0].shape[0]]
        lay_pixels(sight.scene, drawn, sight.others[view], pixels, lanes)
        fill_rows(sight.scene, drawn, training.limit, (lanes, wider), own)
        add_squares(own, common)
        add_turns(drawn, pixels, lanes[-BESIDE + SHADOW], own, (among, across))
    put_in_place(common, among, across, equations)


@compiled
def fold(
    own: Equations, places: tuple[Places, Places], turn: tuple[Floats, Places], whole: Equations
) -> None:
    """Add C^T N C and C^T r to the whole, N and r being the own equations of one view.

    C copies most unknowns to their places in the whole, and combines a few into others linearly.

    Parameters
    ----------
    own
        The lower triangle alone.
    places
        Index of each unknown in the whole, -1 where it is absent, shape (own,); the unknowns that
        are turned, shape (turned,).
    turn
        Their derivatives to unknowns of the whole, shape (turned, others), and where those stand.
    whole
        Both triangles.
    """
    (at, bent), (change, others), size = places, turn, own.right.size
    half = np.zeros((size, others.size))
    for p in range(size):
        for q in range(bent.size):
            product = own.normal[max(p, bent[q]), min(p, bent[q])]
            for c in range(others.size):
                half[p, c] += product * change[q, c]
    for p in range(size):
        if at[p] < 0:
            continue
        whole.right[at[p]] += own.right[p]
        for q in range(p + 1):
            if at[q] >= 0:
                whole.normal[at[p], at[q]] += own.normal[p, q]
                if p != q:
                    whole.normal[at[q], at[p]] += own.normal[p, q]
        for c in range(others.size):
            whole.normal[at[p], others[c]] += half[p, c]
            whole.normal[others[c], at[p]] += half[p, c]
    for q in range(bent.size):
        for c in range(others.size):
            whole.right[others[c]] += change[q, c] * own.right[bent[q]]
            for d in range(others.size):
                whole.normal[others[c], others[d]] += change[q, c] * half[bent[q], d]


@compiled
def eliminate(whole: Equations, first: int, left: Equations) -> None:
    """Add the equations of all but the first unknowns, these as nuisance parameters (Schur)."""
    inverse, others = inverse_of(whole.normal[:first, :first]), whole.right.size - first
    gain, row = np.zeros((first, others)), np.zeros(others)
    for a in range(first):
        for k in range(first):
            for c in range(others):
                gain[a, c] += inverse[a, k] * whole.normal[k, first + c]
    for a in range(others):
        for c in range(others):
            row[c] = whole.normal[first + a, first + c]
        for k in range(first):
            for c in range(others):
                row[c] -= whole.normal[k, first + a] * gain[k, c]
            left.right[a] -= gain[k, a] * whole.right[k]
        left.right[a] += whole.right[first + a]
        for c in range(others):
            left.normal[a, c] += row[c]


Bending = Callable[[Optics, int, Floats], Floats]
"""What unknowns of the camera change in a view of a sphere at a centre, shape (BENT, unknowns)."""

MARKER_PRIOR, DARKNESS_PRIOR, ALPHA_PRIOR = 0.2, 0.2, 0.05
RADIUS_PRIOR, BLUR_PRIOR, SCALE_PRIOR, HELD = 0.003, 0.05, 0.05, 1e-9
BENDS_PRIOR, LOG_RADIUS_PRIOR = np.array([1.0, 1.0]), 0.01
BENDS = len(BENDS_PRIOR)
"""Expected sizes of a correction; radius and blur come from the shading and only take part."""
SHADING_PRIOR = 50.0
"""Grey levels by which a coefficient of the shading may be wrong."""
GAUGE = 1e-4
"""Most that all markers turn together, radians."""


@dataclass(frozen=True, slots=True, eq=False)
class Shared:
    """Corrections to what the frames of a sphere share, from `solve_shared`.

    Attributes
    ----------
    markers
        Turns about the two tangents of each marker, radians, shape (markers, 2).
    marker_sigma
        Standard error of a marker's direction across it by the noise, radians, the median.
    darkness, alpha
        Of the markers.
    camera
        Log radius of the sphere that the markers lie on, log of the scale of each view behind the
        front view against that one's, as the tracks have it, the camera's nearness, 1/m, and the
        columns, px, by which the mirror's view is shifted, shape (V + 2,).
    camera_weight
        Inverse of their covariance, shape (V + 2, V + 2).
    limb
        Log of the radius by the outline over the radius by the markers.
    """

    markers: Floats
    marker_sigma: float
    darkness: float
    alpha: float
    camera: Floats
    camera_weight: Floats
    limb: float


def shared_size(markers: int, views: int, bends: int = BENDS) -> int:
    """Return the number of shared unknowns, the last of them what bends the camera."""
    return 2 * markers + MARKERS_SHARE + VIEW_SHARE * views + bends


def add_frame(
    sight: Sight,
    stance: Stance,
    training: TrainingView,
    shared: Equations,
    bending: Bending = by_nearness_and_shift,
) -> None:
    """Add one frame to the full equations of the shared unknowns, its own eliminated (Schur)."""
    views, markers = sight.optics.scales.shape[0], sight.look.markers.shape[0]
    common = 2 * markers + MARKERS_SHARE
    local = POSE + LIGHTS * views
    total = local + len(shared.right)
    bent = [0, 1, 2, 3, 4, UNKNOWNS + common, UNKNOWNS + common - 1]
    whole = Equations(np.zeros((total, total)), np.zeros(total))
    size = UNKNOWNS + common + VIEW_SHARE
    for view in range(views):
        own = Equations(np.zeros((size, size)), np.zeros(size))
        bundle_view(sight, stance, view, training, own)
        bends = bending(sight.optics, view, stance.centre)
        turn = np.zeros((len(bent), POSE + bends.shape[1]))
        turn[:5, :POSE] = into_world(sight.optics, view, stance.centre)
        turn[:, POSE:] = bends
        pose = [*range(POSE), *range(total - bends.shape[1], total)]
        lights = range(POSE + LIGHTS * view, POSE + LIGHTS * (view + 1))
        behind = local + common + VIEW_SHARE * view
        shares = [*range(local, local + common), *range(behind, behind + VIEW_SHARE)]
        at = np.array([-1] * 5 + [*lights, *shares])
        fold(own, (at, np.array(bent)), (turn, np.array(pose)), whole)
    add_priors(sight, stance, whole)
    eliminate(whole, local, shared)


def solve_shared(equations: Equations, tangents: Floats, views: int, *, settled: int = 0) -> Shared:
    """Solve for the shared unknowns; weak priors hold what no frame determines.

    Parameters
    ----------
    tangents
        Of the markers, as in the training, shape (markers, 2, 3).
    settled
        How many of the first markers stay, and with them their look and the camera. They hold the
        others, which may turn together.
    """
    markers = len(tangents)
    sizes = shared_prior(markers, views, BENDS_PRIOR)
    if settled:
        sizes[: 2 * settled] = sizes[2 * markers : 2 * markers + MARKERS_SHARE] = HELD
        sizes[[*range(2 * markers + MARKERS_SHARE + SCALE, len(sizes) - BENDS, VIEW_SHARE)]] = HELD
        sizes[-BENDS:] = HELD
    held = equations.normal + np.diag(sizes**-2.0)
    if not settled:
        held[: 2 * markers, : 2 * markers] += together(tangents)
    inverse = np.linalg.inv(held)
    step = inverse @ equations.right
    views_from = 2 * markers + MARKERS_SHARE
    on_markers, on_limb = views_from - 1, views_from
    bends = range(len(step) - BENDS, len(step))
    ratios = range(views_from + VIEW_SHARE + SCALE, bends.start, VIEW_SHARE)
    camera = [on_markers, *ratios, *bends]
    return Shared(
        markers=step[: 2 * markers].reshape(markers, 2),
        marker_sigma=float(np.sqrt(np.median(np.diag(inverse)[: 2 * markers]))) if markers else 0.0,
        darkness=float(step[2 * markers]),
        alpha=float(step[2 * markers + 1]),
        camera=step[camera],
        camera_weight=np.linalg.inv(inverse[np.ix_(camera, camera)]),
        limb=float(step[on_limb] - step[on_markers]),
    )


def shared_prior(markers: int, views: int, bends: Floats) -> Floats:
    """Return the expected sizes of the shared unknowns, those of the camera's bends given."""
    shading = [SHADING_PRIOR] * len(HARMONICS)
    return np.concatenate(
        [
            np.full(2 * markers, MARKER_PRIOR),
            [DARKNESS_PRIOR, ALPHA_PRIOR, LOG_RADIUS_PRIOR],
            [RADIUS_PRIOR, BLUR_PRIOR, HELD, HELD, *shading],
            np.tile([RADIUS_PRIOR, BLUR_PRIOR, SCALE_PRIOR, HELD, *shading], views - 1),
            bends,
        ]
    )


def together(tangents: Floats) -> Floats:
    """Return the weights that keep all markers from turning together, shape (2 M, 2 M).

    That is all poses turned back; near a camera it holds to first order only, and what is left
    over would set the pattern drifting.
    """
    common = tangents.reshape(-1, 3) / GAUGE
    return np.asarray(common @ common.T)


def tangents_of(markers: Floats) -> Floats:
    """Return two unit vectors across each marker, shape (markers, 2, 3)."""
    helper = np.eye(3)[np.abs(markers).argmin(axis=1)]
    first = np.cross(markers, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(markers, first)], axis=1)
