"""A sensor that is read block by block: low rows are later than high ones."""

from __future__ import annotations

import numpy as np

from analysis.effects.effect import ClockEffect, Exposure, Floats, Parameter, Values
from analysis.effects.frame_place import frame_places
from analysis.imaging.views import View
from analysis.setup import CameraSetup


def expose(exposure: Exposure, camera: CameraSetup, values: Values) -> tuple[Floats, Floats]:
    """Return t + b T (row / height), rows counted from the frame's centre, T the frame time.

    The staircase of blocks is taken as its mean slope: the outline of a sphere spans two or three
    blocks, and the fit of a circle averages over them. Without a stated scale the rows are not
    known, and nothing is delayed.
    """
    stated = np.repeat(exposure.times_s[..., None], 2, axis=2)
    scale = camera.scale_px_per_m
    if scale is None:
        return stated, stated
    row = frame_places(exposure.position, camera, scale)[View.FRONT][..., 0]
    late = values[0] / camera.frame_rate_hz * row / camera.height_px
    true = np.asarray(stated + late)
    return true, true


EFFECT = ClockEffect(
    name="block-readout",
    title="Block-wise readout of the sensor",
    parameters=(
        Parameter(
            symbol="b",
            unit="1",
            meaning="share of the frame time that reading from the top row to the bottom row takes",
            plausible=(0.0, 1.0),
            step=1e-4,
            one_sided=True,
        ),
    ),
    formula="t_true = t + b T row / rows, row from the frame's centre",
    source=(
        "Kodak EktaPro 1012 at 1000 frames/s: 12 blocks of 16 rows, from the top downward, each "
        "83 microseconds after the one above it"
    ),
    gives_away="the lower sphere is ahead of its track in proportion to its speed and its row",
    confused_with=("exposure-offset", "camera-roll", "finite-contact"),
    expose=expose,
)
