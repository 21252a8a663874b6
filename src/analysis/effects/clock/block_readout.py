"""A sensor that is read block by block: low rows are later than high ones."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from analysis.arrays import Floats
from analysis.effects.camera.frame_place import frame_places
from analysis.effects.effect import ClockEffect, Exposure, Parameter, Values
from analysis.imaging.views import View
from analysis.setup import CameraSetup

BLOCKS = 12

Rows = Callable[[Floats, CameraSetup], Floats]
"""Rows from the frame's centre, to the rows whose time the pose of a sphere there has."""


def mean_slope(row: Floats, camera: CameraSetup) -> Floats:
    """Return the rows themselves.

    The outline of a sphere spans two or three blocks, and the fit of a circle averages over them.
    """
    del camera
    return row


def block_of_centre(row: Floats, camera: CameraSetup) -> Floats:
    """Return the middle of the block that holds the centre, for poses that are dated by it."""
    height = camera.height_px / BLOCKS
    from_top = row + camera.height_px / 2
    return np.asarray((np.floor(from_top / height) + 0.5) * height - camera.height_px / 2)


def exposed(
    exposure: Exposure, camera: CameraSetup, values: Values, rows: Rows
) -> tuple[Floats, Floats]:
    """Return t + b T row / height, T the frame time, shapes (S, F, 2, 3) and (S, F, 2).

    X and Y are shown by the front view, Z by the top view, the orientation by both. Without a
    stated scale the rows are not known, and nothing is delayed.
    """
    stated = exposure.times_s[..., None]
    scale = camera.scale_px_per_m
    if scale is None:
        return stated[..., None], stated
    places = frame_places(exposure.position, camera, scale)
    front = rows(places[View.FRONT][..., 0], camera)
    top = rows(places.get(View.TOP, places[View.FRONT])[..., 0], camera)
    slope = values[0] / camera.frame_rate_hz / camera.height_px
    late = slope * np.stack([front, front, top], axis=-1)
    return stated[..., None] + late, stated + slope * (front + top) / 2


def effect_with(title: str, rows: Rows, variants: tuple[ClockEffect, ...] = ()) -> ClockEffect:
    """Return the effect with one way to date a sphere that spans several blocks."""

    def expose(exposure: Exposure, camera: CameraSetup, values: Values) -> tuple[Floats, Floats]:
        return exposed(exposure, camera, values, rows)

    return ClockEffect(
        name="block-readout",
        title=title,
        parameters=(
            Parameter(
                symbol="b",
                unit="1",
                meaning="share of the frame time that reading from top to bottom takes",
                plausible=(0.0, 1.0),
                step=1e-4,
                one_sided=True,
            ),
        ),
        formula="t_true = t + b T row / rows, row from the frame's centre",
        source=(
            "Kodak EktaPro 1012 at 1000 frames/s: 12 blocks of 16 rows, from the top downward, "
            "each 83 microseconds after the one above it"
        ),
        gives_away="the lower sphere is ahead of its track in proportion to its speed and its row",
        confused_with=("exposure-offset", "camera-roll", "finite-contact"),
        expose=expose,
        variants=variants,
    )


EFFECT = effect_with(
    "Block-wise readout of the sensor",
    mean_slope,
    (effect_with("Block-wise readout, dated by the block of the centre", block_of_centre),),
)
