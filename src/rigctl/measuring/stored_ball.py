"""From the frames of a sphere that bounces on a plate to the shot's result."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.balls.analysis import analyse_held
from analysis.balls.document import ball_document
from analysis.balls.films.film import HeldFilm
from analysis.balls.films.reading import open_film
from analysis.balls.flight.known import Ball
from analysis.errors import ShotRefusedError
from analysis.setup import Setup
from rigctl.documents import Json
from rigctl.store.folders import FRAMES, read_pixels


def bounces_document(kept: Path, times_s: NDArray[np.float64], setup: Setup) -> Json:
    """Return `impacts` in order of time (commands.md), or the refusal.

    Parameters
    ----------
    kept
        Frames of the shot in its folder, named in refusals.
    times_s
        From the first frame, shape (frames,).
    setup
        Whose sphere b is a plate.
    """
    # An import keeps its film as it came: all bits, and what its file says of its pictures.
    film = HeldFilm(kept, read_pixels(kept)) if kept.name == FRAMES else open_film(kept)
    try:
        found = analyse_held(film, times_s, Ball.of_setup(setup), setup.camera.exposure_s)
    except ShotRefusedError as refusal:
        place = {} if refusal.frame is None else {"frame": refusal.frame}
        return {"status": "refused", "step": refusal.step, **place, "reason": refusal.reason}
    return ball_document(found.measured, found.notes)
