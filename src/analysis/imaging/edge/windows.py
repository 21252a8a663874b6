"""Edges looked for only about places of a frame: filter, zero crossings, roots and labels at once.

The same steps as alone (`edges`, `facet`, `labels`), in one compiled pass over small windows. What
is found within a window is what the whole frame would give there.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles
from analysis.compiled import compiled, part
from analysis.imaging.edge.edges import STRIP, filter_strip, framed_strip
from analysis.imaging.edge.facet import mark_row
from analysis.imaging.edge.labels import join_neighbours, name_roots
from analysis.imaging.edge.roots import add_roots

Integers = NDArray[np.int32]
Filters = tuple[Singles, tuple[float, int, int]]
"""`edges.half_kernels`; gradient below which a crossing is noise, pixels to keep off the frame's
border, and samples that a pixel's root is rounded to, 0 for none."""
Marked = tuple[Integers, NDArray[np.intp], Floats, NDArray[np.bool_]]
"""Number of the marked pixel counted from 1 at each pixel of a frame; rows and columns of marked
pixels, shape (most, 2); what `roots.add_roots` fills, shape (most, 5); whether it found a root."""


@compiled
def edges_about(
    frame: Singles,
    places: Floats,
    taps: Singles,
    limits: tuple[float, int, int],
) -> tuple[Floats, NDArray[np.intp], Integers]:
    """Find the edge points about some places of a frame, and the curve that each belongs to.

    Parameters
    ----------
    frame
        Grey levels, shape (rows, columns).
    places
        Row, column and reach of each square, pixels, shape (places, 3).
    taps
        `edges.half_kernels`.
    limits
        Gradient below which a crossing is noise; pixels to keep off the frame's border; samples
        that a pixel's root is rounded to, 0 for none.

    Returns
    -------
    Rows, columns, unit normals and strengths, shape (5, points); rows and columns of their pixels,
    shape (2, points); and labels from 1, shape (points,).
    """
    rows, columns = frame.shape
    boxes, most = np.empty((places.shape[0], 4), dtype=np.intp), 0
    for n in range(places.shape[0]):
        most += fill_box(places[n], (rows, columns), limits[1], boxes[n])
    number = np.zeros((rows, columns), dtype=np.int32)
    pixels, points = np.empty((most, 2), dtype=np.intp), np.empty((most, 5))
    found = np.empty(most, dtype=np.bool_)
    count = 0
    marked, widest = (number, pixels, points, found), STRIP - 2 * taps.shape[1]
    for n in range(places.shape[0]):
        box, last = boxes[n], boxes[n, 3]
        while box[2] < last and box[0] < box[1]:
            box[3] = min(box[2] + widest, last)
            count = mark_box(frame, box, (taps, limits[0]), marked, count)
            box[2] = box[3]
    parent = np.arange(count + 1).astype(np.int32)
    join_neighbours(number, pixels[:count], parent)
    name_roots(parent)
    kept = found[:count].sum()
    filled, at = np.empty((5, kept)), np.empty((2, kept), dtype=np.intp)
    labels, k, fine = np.empty(kept, dtype=np.int32), 0, float(limits[2])
    for n in range(count):
        if not found[n]:
            continue
        for a in range(2):
            off = points[n, a] if fine == 0.0 else np.rint(points[n, a] * fine) / fine
            at[a, k], filled[a, k] = pixels[n, a], pixels[n, a] + off
        for a in range(2, 5):
            filled[a, k] = points[n, a]
        labels[k] = parent[n + 1]
        k += 1
    return filled, at, labels


@part
def fill_box(place: Floats, shape: tuple[int, int], border: int, box: NDArray[np.intp]) -> int:
    """Fill first and last row and column of a square within a frame; return its pixels."""
    for a in range(2):
        box[2 * a] = max(math.ceil(place[a] - place[2]), border)
        box[2 * a + 1] = max(
            min(math.floor(place[a] + place[2]) + 1, shape[a] - border), box[2 * a]
        )
    return int((box[1] - box[0]) * (box[3] - box[2]))


@part
def which(marked: NDArray[np.bool_], places: NDArray[np.intp]) -> int:
    """Fill the places that are marked; return how many. Few are, at random: no branch guesses."""
    count = 0
    for c in range(marked.size):
        places[count] = c
        count += marked[c]
    return count


@part
def mark_box(
    frame: Singles,
    box: NDArray[np.intp],
    filters: tuple[Singles, float],
    marked: Marked,
    count: int,
) -> int:
    """Add the marked pixels of a box with their roots to `count` before; return their number.

    Parameters
    ----------
    box
        No wider than a strip without its margins.
    filters
        `edges.half_kernels`, and the gradient below which a crossing is noise.
    """
    number, pixels, points, found = marked
    height, width = box[1] - box[0], box[3] - box[2]
    # One more on each side: a facet has its neighbours.
    left = filters[0].shape[1]
    framed = framed_strip(frame, (box[0] - left, box[2] - left), height + 2 * left)
    log = np.empty((height + 2, STRIP), dtype=np.float32)
    edges = log, np.empty_like(log), np.empty_like(log)
    filter_strip(framed, filters[0], edges)
    crossing = np.empty(STRIP, dtype=np.bool_)
    marked_here = np.empty(width, dtype=np.intp)
    before, corner = count, (box[0] - 1, box[2] - left)
    for r in range(1, height + 1):
        mark_row(edges, r, (left, left + width), filters[1], crossing)
        for n in range(which(crossing[left : left + width], marked_here)):
            row, column = box[0] + r - 1, box[2] + marked_here[n]
            if number[row, column] == 0:
                pixels[count, 0], pixels[count, 1] = row, column
                count += 1
                number[row, column] = count
    add_roots(edges, pixels[before:count], corner, points[before:count], found[before:count])
    return count
