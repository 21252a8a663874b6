"""From a shot's folder to its result: the one call from the daemon into the analysis."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from analysis.document import overlay_document
from analysis.setup import DRAG_SIGMA, CameraSetup, Setup, SphereSetup
from analysis.shot import AnalysisOptions, MeasuredShot, RefusedShot, analyse_shot
from rigctl.measuring.analysis_process import AGAIN
from rigctl.measuring.learned_pairs import LearnedPairs
from rigctl.measuring.lesson import Lesson
from rigctl.measuring.stored_poses import measured_document
from rigctl.store.folders import read_pixels

if TYPE_CHECKING:
    from analysis.photometric.learn.appearance import Knowledge

Json = dict[str, Any]
Floats = NDArray[np.float64]
Measure = Callable[[NDArray[np.uint8], Floats, Setup, AnalysisOptions], MeasuredShot | RefusedShot]

LEARNED = "learned"
"""Folder beside the shots, for what is learned of their spheres."""


def analyse_stored_shot(folder: Path, method: str) -> Json:
    """Analyse the frames in a shot's folder; the manifest says all that must be known.

    Times count from the shot's first frame.

    Returns
    -------
    The result document (commands.md) with the shot's name, the method, the frame rate and,
    when it was measured, the poses of both spheres and what to draw over each frame. `AGAIN` names
    shots that are worth another analysis, now that more is known of their spheres.
    """
    campaign = json.loads((folder / "manifest.json").read_bytes()).get("campaign")
    lesson = Lesson(folder, campaign, pairs_beside(folder), read_stored_shot)
    return {**_result(folder, method, lesson.measure), AGAIN: list(lesson.again)}


@lru_cache(maxsize=1)
def _pairs_in(folder: Path) -> LearnedPairs:
    return LearnedPairs(folder)


def pairs_beside(folder: Path) -> LearnedPairs:
    """Return the learned pairs of the store that a shot's folder belongs to."""
    return _pairs_in(folder.parents[2] / LEARNED)


def analyse_stored_shot_as_taught(folder: Path, method: str, known: Knowledge | None) -> Json:
    """Analyse as `analyse_stored_shot`, with nothing but what is handed over.

    The same shot, method and knowledge give the same result, in whatever process and order.
    """

    def measure(
        frames: NDArray[np.uint8], times_s: Floats, setup: Setup, options: AnalysisOptions
    ) -> MeasuredShot | RefusedShot:
        return analyse_shot(frames, times_s, setup, options, known)

    return _result(folder, method, measure)


def read_stored_shot(folder: Path) -> tuple[NDArray[np.uint8], Floats, Setup]:
    """Return a shot's frames, their times in s from the first, and the set-up they were taken in.

    Raises
    ------
    ValueError, OSError, KeyError
        They cannot be read.
    """
    manifest = json.loads((folder / "manifest.json").read_bytes())
    times_s = np.array(manifest["frames"]["times_s"])
    return (
        read_pixels(folder / manifest["frames"]["file"]),
        times_s - times_s[:1],
        setup_of(manifest),
    )


def _result(folder: Path, method: str, measure: Measure) -> Json:
    manifest = json.loads((folder / "manifest.json").read_bytes())
    about: Json = {
        "shot": manifest["shot"],
        "method": method,
        "version": version("rigctl"),
        "frame_rate_hz": manifest["picture_rate_hz"],
    }
    if any("plate" in body for body in manifest["spheres"]):
        reason = "one body is a plate; two spheres are needed"
        return {**about, "status": "refused", "step": "setup", "reason": reason}
    frames = read_pixels(folder / manifest["frames"]["file"])
    times_s = np.array(manifest["frames"]["times_s"])
    options = AnalysisOptions(method="photometric" if method == "photometric" else "thesis")
    shot = measure(frames, times_s - times_s[:1], _exposed(manifest), options)
    document = {**about, **measured_document(shot)}
    if isinstance(shot, MeasuredShot):
        document["overlay"] = overlay_document(shot)
    return document


def _exposed(manifest: Json) -> Setup:
    """Return the set-up with this shot's own exposure, where it is known."""
    setup = setup_of(manifest)
    own = manifest.get("exposure_s")
    camera = setup.camera if own is None else replace(setup.camera, exposure_s=float(own))
    return replace(setup, camera=camera)


def setup_of(manifest: Json) -> Setup:
    """Return what the analysis must know of camera, spheres and surroundings."""
    optics, camera = manifest["optics"], manifest["camera"]
    a, b = (
        SphereSetup(
            name=body["name"],
            diameter_m=body["diameter_m"],
            density_kg_per_m3=body["density_kg_per_m3"],
            inertia_factor=body["inertia_factor"],
        )
        for body in manifest["spheres"]
    )
    return Setup(
        camera=CameraSetup(
            frame_rate_hz=manifest["picture_rate_hz"],
            height_px=camera["rows"],
            width_px=camera["columns"],
            front_view_rows=tuple(optics["front_view_rows"]),
            top_view_rows=_rows(optics["top_view_rows"]),
            scale_px_per_m=optics["scale_px_per_m"],
            front_origin_px=_pixel(optics["front_origin_px"]),
            top_origin_px=_pixel(optics["top_origin_px"]),
            exposure_s=_seconds(camera.get("exposure_us")),
        ),
        spheres=(a, b),
        gravity_m_per_s2=manifest["environment"]["gravity_m_per_s2"],
        air_density_kg_per_m3=manifest["environment"]["air_density_kg_per_m3"],
        drag_coefficient=manifest["environment"].get("drag_coefficient"),
        drag_sigma=manifest["environment"].get("drag_coefficient_sigma", DRAG_SIGMA),
    )


def _pixel(values: list[float] | None) -> tuple[float, float] | None:
    return None if values is None else (values[0], values[1])


def _seconds(microseconds: float | None) -> float | None:
    return None if microseconds is None else microseconds * 1e-6


def _rows(values: list[int] | None) -> tuple[int, int] | None:
    return None if values is None else (values[0], values[1])
