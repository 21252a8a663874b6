"""From the frames of a sphere that bounces on a plate to the shot's result."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.balls.analysis import analyse_held
from analysis.balls.document import ball_document
from analysis.balls.films.film import HeldFilm
from analysis.balls.flight.known import Ball
from analysis.errors import ShotRefusedError
from analysis.setup import Setup
from rigctl.documents import Json


def bounces_document(
    folder: Path, frames: NDArray[np.uint8], times_s: NDArray[np.float64], setup: Setup
) -> Json:
    """Return `impacts` in order of time (commands.md), or the refusal.

    Parameters
    ----------
    folder
        Of the shot, named in refusals.
    frames
        Shape (frames, rows, columns).
    times_s
        From the first frame, shape (frames,).
    setup
        Whose sphere b is a plate.
    """
    film = HeldFilm(folder, frames)
    try:
        found = analyse_held(film, times_s, Ball.of_setup(setup), setup.camera.exposure_s)
    except ShotRefusedError as refusal:
        place = {} if refusal.frame is None else {"frame": refusal.frame}
        return {"status": "refused", "step": refusal.step, **place, "reason": refusal.reason}
    return ball_document(found.measured, found.notes)
