"""All effects that come with the project, in the order of the stages they act in."""

from __future__ import annotations

from analysis.effects import drag, frame_rate, image_scale, restitution_viscoelastic
from analysis.effects.effect import Effect

CATALOGUE: tuple[Effect, ...] = (
    restitution_viscoelastic.EFFECT,
    drag.EFFECT,
    image_scale.EFFECT,
    frame_rate.EFFECT,
)
