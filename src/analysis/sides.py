"""One side of a contact."""

from __future__ import annotations

from dataclasses import dataclass

from analysis.shot_poses import Frames


@dataclass(frozen=True, slots=True, eq=False)
class Side:
    """Clear frames on one side of the contact, as rows of the shot's poses.

    Attributes
    ----------
    word
        "before" or "after".
    nearest
        Which of the rows lies next to the contact, 0 or -1.
    """

    word: str
    rows: Frames
    nearest: int
