"""All effects that come with the project, in the order of the stages they act in."""

from __future__ import annotations

from analysis.effects import (
    block_readout,
    buoyancy,
    camera_roll,
    drag,
    exposure_offset,
    frame_rate,
    gravity_direction,
    gravity_value,
    image_scale,
    magnus_lift,
    mirror_angle,
    perspective,
    pixel_aspect,
    radial_distortion,
    restitution_viscoelastic,
    spin_decay,
    wind,
)
from analysis.effects.effect import Effect

CATALOGUE: tuple[Effect, ...] = (
    restitution_viscoelastic.EFFECT,
    drag.EFFECT,
    wind.EFFECT,
    magnus_lift.EFFECT,
    buoyancy.EFFECT,
    spin_decay.EFFECT,
    gravity_value.EFFECT,
    gravity_direction.EFFECT,
    image_scale.EFFECT,
    pixel_aspect.EFFECT,
    radial_distortion.EFFECT,
    perspective.EFFECT,
    mirror_angle.EFFECT,
    camera_roll.EFFECT,
    frame_rate.EFFECT,
    exposure_offset.EFFECT,
    block_readout.EFFECT,
)
