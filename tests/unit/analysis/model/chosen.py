"""Effects by name: a longer catalogue changes no test."""

from __future__ import annotations

from dataclasses import replace

from analysis.effects.catalogue import CATALOGUE
from analysis.effects.effect import Effect


def chosen(*names: str) -> tuple[Effect, ...]:
    known = {effect.name: effect for effect in CATALOGUE}
    return tuple(known[name] for name in names)


EFFECTS = chosen(
    "restitution-viscoelastic",
    "drag",
    "magnus-lift",
    "gravity-value",
    "gravity-direction",
    "image-scale",
    "pixel-aspect",
    "mirror-angle",
    "camera-roll",
    "frame-rate",
)


def believed_up_to(effect: Effect, largest: float) -> Effect:
    """Return an effect of one parameter that is believed in a range about zero."""
    [parameter] = effect.parameters
    return replace(effect, parameters=(replace(parameter, plausible=(-largest, largest)),))


WIDELY_BELIEVED = tuple(
    believed_up_to(effect, 0.5) if effect.name in {"frame-rate", "gravity-value"} else effect
    for effect in EFFECTS
)
"""With a clock and a gravity so far off that 30 shots see them."""
