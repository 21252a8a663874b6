"""From a shot's folder to its result: the one call from the daemon into the analysis.

The spheres of a campaign are learned while its shots come one by one.
"""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from analysis.arrays import Floats, Grey
from analysis.campaign import TEACHING_SHOTS
from analysis.document import overlay_document
from analysis.setup import Setup, setup_of
from analysis.shot import AnalysisOptions, MeasuredShot, RefusedShot, analyse_shot
from rigctl.documents import Json
from rigctl.measuring.learned_pairs import LearnedPairs
from rigctl.measuring.result_keeping import AGAIN
from rigctl.measuring.stored_poses import measured_document
from rigctl.progress import Progress
from rigctl.store.folders import read_light

if TYPE_CHECKING:
    from analysis.photometric.learn.appearance import Appearance
from numpy.typing import NDArray

from analysis.balls.analysis import analyse_held
from analysis.balls.document import ball_document
from analysis.balls.films.film import HeldFilm
from analysis.balls.films.reading import open_film
from analysis.balls.flight.known import Ball
from analysis.errors import ShotRefusedError
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


_log = logging.getLogger(__name__)

Read = Callable[[Path], tuple[Grey, Floats, Setup]]
"""From a shot's folder to its frames, their times in s from the first, and its set-up."""


class CampaignLearning:
    """Measures one shot with what is known of its pair, and learns from it where more is needed.

    The first shot of a campaign teaches the photometric method; those that follow add markers on
    sides not seen before. Once there are as many as a stored campaign is learned from, all of them
    teach together, and from then on every shot has the same body axes; markers are still added.
    The first ones are then worth another analysis. A later shot that shows other spheres begins
    anew.

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
        self, frames: Grey, times_s: Floats, setup: Setup, options: AnalysisOptions
    ) -> MeasuredShot | RefusedShot:
        """Measure the shot; times in s from its first frame."""
        if options.method != "photometric":
            return analyse_shot(frames, times_s, setup, options)
        name, teachers = self._folder.name, self._pairs.teachers(self._campaign, setup)
        known = self._pairs.recall(self._campaign, setup)
        complete = known is not None and len(teachers) >= TEACHING_SHOTS
        shot = analyse_shot(frames, times_s, setup, options, known, extend=True)
        if not isinstance(shot, MeasuredShot):
            return shot
        strange = shot.tracking.learned_alone and known is not None
        if complete and not strange:
            if shot.known is not known:
                self._keep(setup, shot.known, teachers)
            return shot
        if complete:
            teachers = ()
        teachers = (*(each for each in teachers if each != name), name)
        together = self._together(teachers) if len(teachers) == TEACHING_SHOTS else None
        # What few shots have shown may lack a side that this one turns to the camera.
        begun = known if strange and len(teachers) > 1 else shot.known
        self._keep(setup, together or begun, teachers)
        if together is None:
            # Spheres that are still being learned have axes of their own in each shot.
            return replace(shot, slow=replace(shot.slow, one_body_frame=False))
        self.again = teachers[:-1]
        return analyse_shot(frames, times_s, setup, options, together)

    def _together(self, teachers: Sequence[str]) -> Appearance | None:
        """Return the appearance learned from shots together; None where learning fails."""
        # Loading compiled functions is slow.
        from analysis.photometric.teaching import teach  # noqa: PLC0415

        shots = []
        for name in teachers:
            with suppress(OSError, ValueError, KeyError):
                shots.append(self._read(self._of_shot(name)))
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


Measure = Callable[[Grey, Floats, Setup, AnalysisOptions], MeasuredShot | RefusedShot]

LEARNED = "learned"
"""Folder beside the shots, for what is learned of their spheres."""


NICENESS = 5
"""Of the analysis: a fire request goes before it, and everything of lower priority after it."""


FIRST_SHOT = 0.8
"""Share of all functions that a first shot calls, 186 of 233."""
TIME_TAKEN = (0.0, 0.08, 0.14, 0.32, 0.45, 0.5, 0.57, 0.63, 0.74, 0.87, 1.0)
"""Share of the processor time of compiling that no function, the first tenth of those that a first
shot calls, two tenths and so on take, in the order in which it calls them."""


def time_taken(done: float) -> float:
    """Return the share of the time of compiling that is over when this share of functions is done.

    A function takes from a tenth of a second to four: a count says less of the time left.
    """
    return float(np.interp(done, np.linspace(0.0, 1.0, len(TIME_TAKEN)), TIME_TAKEN))


@cache
def _report_compilation(progress: Progress) -> None:
    """Report from now on; once, for a process has one progress for all its orders."""
    # Loaded here: the daemon starts without the compiler.
    from analysis.compiled import on_compilation  # noqa: PLC0415

    def report(done: int, functions: int) -> None:
        of = max(done, round(FIRST_SHOT * functions))
        progress(f"{done} of about {of} functions", time_taken(done / of))

    on_compilation(report)


@cache
def _stand_back() -> None:
    os.nice(NICENESS)


def analysis_job(arguments: Json, progress: Progress) -> Json:
    """Analyse the shot of a `folder` by a `method`, in a process of its own.

    Progress is that of compilation alone.
    """
    _report_compilation(progress)
    try:
        return analyse_stored_shot(Path(arguments["folder"]), arguments["method"])
    finally:
        # Not before: others may wait for the machine code that the first shot compiles.
        _stand_back()


def analyse_stored_shot(folder: Path, method: str) -> Json:
    """Analyse the frames in a shot's folder; the manifest has all that is needed.

    Times count from the shot's first frame.

    Returns
    -------
    The result document (commands.md) with the shot's name, the method, the frame rate and,
    when it was measured, the poses of both spheres. What was found in the frames is there to be
    drawn, of a refused shot as well: `overlay` by frame, or `discs` in the refused one. `AGAIN`
    names shots that are worth another analysis, now that more is known of their spheres.
    """
    campaign = json.loads((folder / "manifest.json").read_bytes()).get("campaign")
    learning = CampaignLearning(folder, campaign, pairs_beside(folder), read_stored_shot)
    return {**_result(folder, method, learning.measure), AGAIN: list(learning.again)}


@lru_cache(maxsize=1)
def _pairs_in(folder: Path) -> LearnedPairs:
    return LearnedPairs(folder)


def pairs_beside(folder: Path) -> LearnedPairs:
    """Return the learned pairs of the store that a shot's folder belongs to."""
    return _pairs_in(folder.parents[2] / LEARNED)


def analyse_stored_shot_with(folder: Path, method: str, known: Appearance | None) -> Json:
    """Analyse as `analyse_stored_shot`, with nothing but what is handed over.

    The same shot, method and knowledge give the same result, in whatever process and order.
    """

    def measure(
        frames: Grey, times_s: Floats, setup: Setup, options: AnalysisOptions
    ) -> MeasuredShot | RefusedShot:
        return analyse_shot(frames, times_s, setup, options, known)

    return _result(folder, method, measure)


def read_stored_shot(folder: Path) -> tuple[Grey, Floats, Setup]:
    """Return a shot's frames, their times in s from the first, and the set-up they were taken in.

    The set-up has the shot's own exposure, where it is known.

    Raises
    ------
    ValueError, OSError, KeyError
        They cannot be read.
    """
    manifest = json.loads((folder / "manifest.json").read_bytes())
    times_s = np.array(manifest["frames"]["times_s"])
    return (
        read_light(folder / manifest["frames"]["file"]),
        times_s - times_s[:1],
        exposed_setup(manifest),
    )


def _result(folder: Path, method: str, measure: Measure) -> Json:
    manifest = json.loads((folder / "manifest.json").read_bytes())
    setup = exposed_setup(manifest)
    about: Json = {
        "shot": manifest["shot"],
        "method": method,
        "version": version("rigctl"),
        "frame_rate_hz": setup.camera.frame_rate_hz,
    }
    kept = folder / manifest["frames"]["file"]
    times_s = np.array(manifest["frames"]["times_s"])
    if setup.spheres[1].plate:
        # What measures balls is slow to load, and of no use to two spheres.
        from rigctl.measuring.stored_shot import bounces_document  # noqa: PLC0415

        return {**about, **bounces_document(kept, times_s - times_s[:1], setup)}
    options = AnalysisOptions(method="photometric" if method == "photometric" else "thesis")
    shot = measure(read_light(kept), times_s - times_s[:1], setup, options)
    if isinstance(shot, MeasuredShot):
        # Those on the file of an import.
        shot = replace(shot, notes=(*manifest["frames"].get("notes", ()), *shot.notes))
    document = {**about, **measured_document(shot)}
    if isinstance(shot, RefusedShot) and shot.discs:
        names = ("row", "column", "radius")
        document["discs"] = [dict(zip(names, disc, strict=True)) for disc in shot.discs]
    if shot.tracking is not None:
        document["overlay"] = overlay_document(shot.tracking, len(times_s))
    return document


def exposed_setup(manifest: Json) -> Setup:
    """Return the set-up with this shot's own exposure, where it is known."""
    setup = manifest_setup(manifest)
    own = manifest.get("exposure_s")
    camera = setup.camera if own is None else replace(setup.camera, exposure_s=float(own))
    return replace(setup, camera=camera)


def manifest_setup(manifest: Json) -> Setup:
    """Return the set-up that a manifest holds.

    Raises
    ------
    KeyError, ValueError
        It holds none, or one beyond its limits.
    """
    if "setup" in manifest:
        return setup_of(manifest["setup"])
    return setup_of(_of_format_1(manifest))


def _of_format_1(manifest: Json) -> Json:
    """Return the set-up of a manifest that spread it over camera, optics and others."""
    camera = manifest["camera"]
    exposure_us = camera.get("exposure_us")
    return {
        "camera": {
            "frame_rate_hz": manifest["picture_rate_hz"],
            "height_px": camera["rows"],
            "width_px": camera["columns"],
            "exposure_s": None if exposure_us is None else exposure_us * 1e-6,
            **manifest["optics"],
        },
        "spheres": manifest["spheres"],
        "environment": manifest["environment"],
    }
