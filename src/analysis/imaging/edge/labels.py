"""Sequential labelling: which edge pixels belong to one curve (thesis, section 4.3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled, part


@part
def root_of(parent: NDArray[np.int32], label: int) -> int:
    """Return the least label that a label is known to equal, and shorten the way to it."""
    while parent[label] != label:
        parent[label] = parent[parent[label]]
        label = parent[label]
    return label


@compiled
def label_connected(mask: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Label the 8-connected components of a mask in one scan and one merge.

    The thesis's scan looks at the left, upper and upper-left neighbour and copies one label,
    losing the equivalence when two differ. Here the upper-right neighbour is looked at too, and
    every equivalence is recorded and merged (B. K. P. Horn, "Robot Vision", 1986, section 4.5).

    Parameters
    ----------
    mask
        Shape (rows, columns).

    Returns
    -------
    Shape (rows, columns): 0 outside the mask, else 1, 2, ... in the order of each component's
    first pixel.
    """
    rows, columns = mask.shape
    labels = np.zeros((rows, columns), dtype=np.int32)
    parent = np.zeros(mask.size // 2 + 2, dtype=np.int32)
    last = 0
    for r in range(rows):
        for c in range(columns):
            if not mask[r, c]:
                continue
            least = 0
            for y, x in ((r - 1, c - 1), (r - 1, c), (r - 1, c + 1), (r, c - 1)):
                if y < 0 or x < 0 or x >= columns or labels[y, x] == 0:
                    continue
                other = root_of(parent, labels[y, x])
                if least > 0:
                    parent[max(least, other)] = min(least, other)
                least = min(least, other) if least > 0 else other
            if least == 0:
                last += 1
                parent[last] = last
                least = last
            labels[r, c] = least
    name = np.zeros(last + 1, dtype=np.int32)
    count = 0
    for label in range(1, last + 1):
        if parent[label] == label:
            count += 1
            name[label] = count
    for r in range(rows):
        for c in range(columns):
            if labels[r, c] != 0:
                labels[r, c] = name[root_of(parent, labels[r, c])]
    return labels


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
