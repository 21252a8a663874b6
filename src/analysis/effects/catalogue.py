"""All effects that come with the project, in the order of the stages they act in."""

from __future__ import annotations

from analysis.effects.camera import (
    camera_roll,
    image_scale,
    mirror_angle,
    perspective,
    pixel_aspect,
    radial_distortion,
)
from analysis.effects.clock import (
    block_readout,
    exposure_offset,
    frame_rate,
    timing_jitter,
)
from analysis.effects.contact import (
    adhesion,
    finite_contact,
    friction_drift,
    friction_speed,
    inertia_factor,
    lasting_contact,
    mass_mismatch,
    mass_offset,
    radius_mismatch,
    restitution_drift,
    restitution_obliquity,
    restitution_plastic,
    restitution_viscoelastic,
    restitution_yield_knee,
    rolling_restitution_speed,
    tangential_compliance,
    torsional_friction,
    velocity_offset,
)
from analysis.effects.effect import Effect, LaunchEffect
from analysis.effects.flight import (
    buoyancy,
    drag,
    gravity_direction,
    gravity_value,
    magnus_lift,
    spin_decay,
    wind,
)
from analysis.effects.launch import (
    launch_delay,
    pressure_friction,
    pressure_hysteresis,
    pressure_leak,
    slide_backlash,
    tube_spin,
)

CATALOGUE: tuple[Effect, ...] = (
    restitution_viscoelastic.EFFECT,
    restitution_plastic.EFFECT,
    restitution_yield_knee.EFFECT,
    restitution_obliquity.EFFECT,
    restitution_drift.EFFECT,
    velocity_offset.EFFECT,
    adhesion.EFFECT,
    lasting_contact.EFFECT,
    finite_contact.EFFECT,
    tangential_compliance.EFFECT,
    friction_speed.EFFECT,
    friction_drift.EFFECT,
    rolling_restitution_speed.EFFECT,
    torsional_friction.EFFECT,
    inertia_factor.EFFECT,
    mass_mismatch.EFFECT,
    radius_mismatch.EFFECT,
    mass_offset.EFFECT,
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
    timing_jitter.EFFECT,
    exposure_offset.EFFECT,
    block_readout.EFFECT,
)

LAUNCH_CATALOGUE: tuple[LaunchEffect, ...] = (
    pressure_friction.EFFECT,
    pressure_hysteresis.EFFECT,
    pressure_leak.EFFECT,
    launch_delay.EFFECT,
    tube_spin.EFFECT,
    slide_backlash.EFFECT,
)
"""Effects of the launch. They act on the start of a shot and not on its collision, so that poses
alone hold no information on them: they are ranked by the settings (`analysis.launch`)."""
