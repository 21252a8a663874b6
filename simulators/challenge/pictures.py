"""Frames of a campaign: its shots under a flash, through the camera that this nature has."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from simulators.challenge.camera import picture
from simulators.challenge.campaign import Fired
from simulators.challenge.nature import Nature
from simulators.world.chance import marked_camera, noise_chance
from simulators.world.description import WorldDescription
from simulators.world.optics import Optics
from simulators.world.render import Camera, digitised
from simulators.world.state import Pose

Floats = NDArray[np.float64]
Picture = NDArray[np.float32]

_BORDER_PX = 24
"""Seen beyond each edge of the picture; no lens of a challenge brings in more."""
_ROUNDS = 12


def filmed(fired: Fired, nature: Nature, optics: Optics, seed: int) -> Iterator[NDArray[np.uint8]]:
    """Yield the frames (F, rows, columns) of each shot.

    The light is a flash: a frame shows one instant, with no smear by motion. Markers and read
    noise hang on the seed alone.

    Parameters
    ----------
    optics
        The camera as it is stated; nature says how the true one differs.
    """
    true = replace(
        _bordered(optics),
        scale_px_per_m=optics.scale_px_per_m * (1.0 + nature.image_scale),
        mirror_rad=nature.mirror_rad,
        exposure_s=0.0,
    )
    camera = marked_camera(WorldDescription(optics=true), seed)
    shots = zip(fired.way.centres, fired.orientations(), strict=True)
    for shot, (centres, turned) in enumerate(shots):
        yield np.stack(
            [
                digitised(
                    _lens(_light(camera, *poses), nature, optics, time),
                    optics.noise_grey,
                    noise_chance(seed, shot + time),
                )
                for *poses, time in zip(centres, turned, fired.times_s.tolist(), strict=True)
            ]
        )


def _bordered(optics: Optics) -> Optics:
    """Return optics that see a border about the picture; its pixels have the same light."""
    row, column = optics.front_origin_px
    top, top_column = optics.top_origin_px
    slopes = optics.background_per_row + optics.background_per_column
    return replace(
        optics,
        rows=optics.rows + 2 * _BORDER_PX,
        columns=optics.columns + 2 * _BORDER_PX,
        front_origin_px=(row + _BORDER_PX, column + _BORDER_PX),
        top_origin_px=(top + _BORDER_PX, top_column + _BORDER_PX),
        background=optics.background - _BORDER_PX * slopes,
    )


def _light(camera: Camera, centres: Floats, turned: Floats) -> Picture:
    """Return the light of a bordered picture of spheres a and b: (2, 3), m, and (2, 4)."""
    pair = [Pose(centre, q) for centre, q in zip(centres, turned, strict=True)]
    return camera.expose(lambda _: pair, 0.0)


def _lens(light: Picture, nature: Nature, optics: Optics, time_s: float) -> Picture:
    """Return the picture (rows, columns) that lens and sensor make of bordered light."""
    shake = nature.shake_px * np.sin(2.0 * np.pi * nature.shake_hz * time_s)
    rows, columns = sources(nature, optics, float(shake))
    # A frame is blurred to 0.8 px, which this interpolation follows to a few parts in a thousand.
    return np.asarray(
        cv2.remap(
            light,
            (columns + _BORDER_PX).astype(np.float32),
            (rows + _BORDER_PX).astype(np.float32),
            cv2.INTER_LANCZOS4,
        ),
        dtype=np.float32,
    )


def sources(nature: Nature, optics: Optics, shake_px: float) -> tuple[Floats, Floats]:
    """Return where the light of each pixel would fall without a fault of lens or sensor.

    The inverse of `picture`, by fixed-point iteration: each round leaves some hundredth of the
    error before it.

    Parameters
    ----------
    shake_px
        By how much the camera's vibration moves the picture along the rows now.

    Returns
    -------
    Rows and columns, each (rows, columns) of the picture.
    """
    places = np.mgrid[: optics.rows, : optics.columns].astype(np.float64)
    wanted_row, wanted_column = places[0] - shake_px, places[1]
    row, column = wanted_row, wanted_column
    for _ in range(_ROUNDS):
        there_row, there_column = picture(row, column, nature, optics)
        row, column = row + wanted_row - there_row, column + wanted_column - there_column
    return row, column
