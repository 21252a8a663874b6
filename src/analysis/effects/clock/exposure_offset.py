"""Orientations that belong to another instant than positions."""

from __future__ import annotations

from analysis.arrays import Floats
from analysis.effects.effect import ClockEffect, Exposure, Parameter, Values
from analysis.setup import CameraSetup


def expose(exposure: Exposure, camera: CameraSetup, values: Values) -> tuple[Floats, Floats]:
    """Return t + d for positions, t for orientations; a shift of both only moves the contact."""
    del camera
    stated = exposure.times_s[..., None]
    return stated[..., None] + values[0], stated


EFFECT = ClockEffect(
    name="exposure-offset",
    title="Offset between exposures of outline and markers",
    parameters=(
        Parameter(
            symbol="d",
            unit="s",
            meaning="time by which positions are later than orientations",
            plausible=(-5e-4, 5e-4),
            step=1e-7,
        ),
    ),
    formula="t_position = t + d, t_orientation = t",
    source="centre of a blur of length v tau, which outline and markers weigh differently",
    gives_away="the instant of contact by the tracks differs from that by the spins",
    confused_with=("finite-contact", "block-readout"),
    expose=expose,
)
