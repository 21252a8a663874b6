"""Sequential labelling: which edge pixels belong to one curve (thesis, section 4.3)."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.compiled import part


@part
def root_of(parent: NDArray[np.int32], label: int) -> int:
    """Return the least label that a label is known to equal, and shorten the way to it."""
    while parent[label] != label:
        parent[label] = parent[parent[label]]
        label = parent[label]
    return label


def label_connected(mask: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Label the 8-connected components of a mask.

    The thesis's scan copies one label where two meet, and loses that they are equal.

    Parameters
    ----------
    mask
        Shape (rows, columns).

    Returns
    -------
    Shape (rows, columns): 0 outside the mask, else 1, 2, ... in the order of each component's
    first pixel.
    """
    labels = cv2.connectedComponentsWithAlgorithm(
        mask.astype(np.uint8), 8, cv2.CV_32S, cv2.CCL_SAUF
    )[1]
    return np.asarray(labels, dtype=np.int32)


@part
def join_neighbours(
    number: NDArray[np.int32], pixels: NDArray[np.intp], parent: NDArray[np.int32]
) -> None:
    """Record which listed pixels touch, in any order of the list.

    Parameters
    ----------
    number
        Place in the list, counted from 1, of each pixel of a frame, 0 of all others.
    pixels
        Row and column of each, none on the frame's border, shape (pixels, 2).
    parent
        Each number itself; the least that it equals is found with `root_of`.
    """
    for n in range(pixels.shape[0]):
        r, c = pixels[n, 0], pixels[n, 1]
        # Of two that touch one is among these of the other.
        for y, x in ((r, c + 1), (r + 1, c - 1), (r + 1, c), (r + 1, c + 1)):
            if number[y, x] > 0:
                own, other = root_of(parent, n + 1), root_of(parent, number[y, x])
                parent[max(own, other)] = min(own, other)


@part
def name_roots(parent: NDArray[np.int32]) -> int:
    """Replace recorded equivalences by names 1, 2, ... in the list's order; return how many."""
    count = 0
    for label in range(1, parent.size):
        # A parent comes before its children, so its name stands already.
        if parent[label] == label:
            count += 1
            parent[label] = count
        else:
            parent[label] = parent[parent[label]]
    return count
