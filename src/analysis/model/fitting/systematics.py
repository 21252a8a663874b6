"""What all shots of a campaign share and is known beforehand with an error: of images, and of air.

It does not average out. Each is fitted beside the law with a prior as wide as it is stated, in the
base model already: what it explains is no finding, and what it hides makes the errors larger.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.effects.camera.image_scale import EFFECT as IMAGE_SCALE
from analysis.effects.camera.orientation_offset import EFFECT as ORIENTATION_OFFSET
from analysis.effects.camera.outline_offset import EFFECT as OUTLINE_OFFSET
from analysis.effects.contact.mass_offset import EFFECT as MASS_OFFSET
from analysis.effects.contact.plate_tilt import EFFECT as PLATE_TILT
from analysis.effects.effect import Effect, Values
from analysis.effects.flight.drag import EFFECT as DRAG
from analysis.effects.flight.gravity_value import EFFECT as GRAVITY_VALUE
from analysis.setup import SlowErrors

OF_IMAGES: tuple[Effect, ...] = (OUTLINE_OFFSET, ORIENTATION_OFFSET, MASS_OFFSET, IMAGE_SCALE)
"""Errors that measuring leaves in the poses of all shots."""


@dataclass(frozen=True, slots=True, eq=False)
class Systematic:
    """An effect that is there as much as it is stated, at some values of its parameters.

    Attributes
    ----------
    sigma
        Standard error of each parameter about its stated value.
    stated
        Stated values of its parameters.
    """

    effect: Effect
    values: Values
    sigma: float
    stated: Values


def of_images(slow: SlowErrors) -> tuple[Systematic, ...]:
    """Return what measuring leaves in poses, by the size of their slow errors.

    Light and learned look stay the same, and so do their errors: of the outlines of both spheres
    against each other, of the orientations of each, and of a learned pattern of markers against its
    sphere. A pattern that is learned anew in each shot (no common body frame) has no error that
    they share. The scale is learned once.
    """
    pattern = slow.common_m if slow.one_body_frame else 0.0
    sizes = (slow.between_m, slow.common_rad, pattern, slow.scale)
    stated = zip(OF_IMAGES, sizes, strict=True)
    return tuple(_off(effect, sigma) for effect, sigma in stated if sigma > 0.0)


def of_air(coefficient: float | None, sigma: float) -> tuple[Systematic, ...]:
    """Return the drag of the air, where the campaign states its coefficient and its error."""
    if coefficient is None:
        return ()
    stated = np.array([coefficient])
    return (Systematic(DRAG, stated, sigma, stated),)


def of_lengths(gravity: float, sigma: float) -> tuple[Systematic, ...]:
    """Return what diameters that are off do: lengths, spheres included, are off by one factor.

    Where spheres touch and how they turn is as it was; gravity, m/s^2, is seen off by that factor.
    """
    wide = abs(gravity) * sigma
    return (_off(GRAVITY_VALUE, wide),) if wide > 0.0 else ()


def of_plate(sigma_rad: float) -> tuple[Systematic, ...]:
    """Return by how much a plate may lean from how it is said to lie."""
    return (_off(PLATE_TILT, sigma_rad),)


def _off(effect: Effect, sigma: float) -> Systematic:
    return Systematic(effect, effect.off, sigma, effect.off)
