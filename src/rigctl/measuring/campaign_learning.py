"""How the spheres of a campaign are learned while its shots come one by one."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from analysis.campaign import TEACHING_SHOTS
from analysis.setup import Setup
from analysis.shot import AnalysisOptions, MeasuredShot, RefusedShot, analyse_shot
from rigctl.measuring.learned_pairs import LearnedPairs

if TYPE_CHECKING:
    from analysis.photometric.learn.appearance import Appearance

_log = logging.getLogger(__name__)

Floats = NDArray[np.float64]
Read = Callable[[Path], tuple[NDArray[np.uint8], Floats, Setup]]
"""From a shot's folder to its frames, their times in s from the first, and its set-up."""


class CampaignLearning:
    """Measures one shot with what is known of its pair, and learns from it where more is needed.

    The first shot of a campaign teaches the photometric method; those that follow add markers on
    sides not seen before. Once there are as many as a stored campaign is learned from, all of them
    teach together, and from then on nothing more is learned: every shot has the same body axes.
    The first ones are then worth another analysis. A shot that shows other spheres begins anew.

    Parameters
    ----------
    folder
        Of the shot.
    pairs
        What the processes of the store have learned.
    read
        Reads the other shots that teach.

    Attributes
    ----------
    again
        Names of shots that are to be analysed once more.
    """

    def __init__(self, folder: Path, campaign: str | None, pairs: LearnedPairs, read: Read) -> None:
        self._folder, self._campaign, self._pairs, self._read = folder, campaign, pairs, read
        self.again: tuple[str, ...] = ()

    def measure(
        self, frames: NDArray[np.uint8], times_s: Floats, setup: Setup, options: AnalysisOptions
    ) -> MeasuredShot | RefusedShot:
        """Measure the shot; times in s from its first frame."""
        if options.method != "photometric":
            return analyse_shot(frames, times_s, setup, options)
        name, teachers = self._folder.name, self._pairs.teachers(self._campaign, setup)
        known = self._pairs.recall(self._campaign, setup)
        complete = known is not None and len(teachers) >= TEACHING_SHOTS
        shot = analyse_shot(frames, times_s, setup, options, known, extend=not complete)
        if not isinstance(shot, MeasuredShot):
            return shot
        if complete and shot.known is known:
            return shot
        if shot.tracking.learned_alone and known is not None:
            teachers = ()
        teachers = (*(each for each in teachers if each != name), name)
        together = self._together(teachers, setup) if len(teachers) == TEACHING_SHOTS else None
        self._keep(setup, together or shot.known, teachers)
        if together is None:
            # Spheres that are still being learned have axes of their own in each shot.
            return replace(shot, slow=replace(shot.slow, one_body_frame=False))
        self.again = teachers[:-1]
        return analyse_shot(frames, times_s, setup, options, together)

    def _together(self, teachers: Sequence[str], setup: Setup) -> Appearance | None:
        """Return the appearance learned from shots together; None where learning fails."""
        # Loading compiled functions is slow.
        from analysis.photometric.method import teach  # noqa: PLC0415

        shots = []
        for name in teachers:
            with suppress(OSError, ValueError, KeyError):
                frames, times_s, _ = self._read(self._of_shot(name))
                shots.append((frames, times_s, setup))
        return teach(shots) if len(shots) == len(teachers) else None

    def _of_shot(self, name: str) -> Path:
        """Return the folder of a shot of the same store, below that of its day."""
        return self._folder.parents[1] / name.partition("-")[0] / name

    def _keep(self, setup: Setup, known: Appearance | None, teachers: Sequence[str]) -> None:
        try:
            if known is not None:
                self._pairs.remember(self._campaign, setup, known)
            self._pairs.keep_teachers(self._campaign, setup, teachers)
        except OSError as error:
            _log.warning("other processes will learn these spheres anew: %s", error)
