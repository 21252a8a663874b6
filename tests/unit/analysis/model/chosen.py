"""Effects by name: a longer catalogue changes no test."""

from __future__ import annotations

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
