"""Sequential labelling: which edge pixels belong to one curve (thesis, section 4.3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


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
    labels = np.zeros((mask.shape[0] + 1, mask.shape[1] + 2), dtype=np.int32)
    parent = [0]

    def root(label: int) -> int:
        while parent[label] != label:
            parent[label] = parent[parent[label]]
            label = parent[label]
        return label

    for row, column in np.argwhere(mask):
        r, c = row + 1, column + 1
        seen = labels[r - 1, c - 1], labels[r - 1, c], labels[r - 1, c + 1], labels[r, c - 1]
        roots = {root(int(label)) for label in seen if label}
        if not roots:
            parent.append(len(parent))
            labels[r, c] = len(parent) - 1
            continue
        least = min(roots)
        labels[r, c] = least
        for other in roots:
            parent[other] = least
    roots_of = np.array([root(label) for label in range(len(parent))])
    _, consecutive = np.unique(roots_of, return_inverse=True)
    return np.asarray(consecutive[labels[1:, 1:-1]], dtype=np.int32)
