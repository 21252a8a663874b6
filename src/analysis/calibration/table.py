"""The estimates of a calibration in words, with their units and effects."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.calibration.bending import DISTORTION, FAULTS, MIRROR, NEARNESS, ROLL
from analysis.calibration.estimate import Estimate
from analysis.calibration.pixel_estimates import PixelEstimate
from analysis.photometric.learn.appearance import Appearance

SCALE_FLOOR, RATIO_FLOOR = 1e-3, 2e-4
NEARNESS_FLOOR, NEARNESS_LEAST = 0.04, 0.02
"""The nearness is good to this share of itself, and to the second, 1/m, at best."""
PLUMB_FLOOR_RAD = 0.02
"""Shadows of spheres that near each other bend their tracks alike in all shots."""


@dataclass(frozen=True, slots=True)
class Answer:
    """Response of the pixel estimates to a camera fault, measured on rendered images.

    Attributes
    ----------
    share
        What is left of it once pattern, shading and poses have been learned with the fault there.
    floor
        What shading and shadows leave, common to all shots.
    loose
        Relative error of `share`.
    """

    share: float
    floor: float
    loose: float = 0.1

    def of(self, change: float, sigma: float) -> tuple[float, float]:
        """Return the fault and its error."""
        value = float(change) / self.share
        return value, math.hypot(sigma / self.share, self.floor, self.loose * value)


ASPECT, DISTORTED = Answer(0.83, 1.5e-3), Answer(0.85, 3e-3)
MIRRORED, ROLLED = Answer(0.62, 3e-3), Answer(0.90, 1.5e-3)
USEFUL_SCALE, USEFUL_ASPECT, USEFUL_ANGLE_RAD = 0.01, 0.02, 0.02
USEFUL_DISTORTION, USEFUL_NEARNESS, USEFUL_PLUMB_RAD = 0.05, 2.0, 0.035
"""Half the plausible ranges of the effects; an estimate with a larger error is of no use."""


def estimates_of(
    found: PixelEstimate, known: Appearance, plumb: tuple[Floats, Floats], *, stated: bool
) -> tuple[Estimate, ...]:
    """Return all estimates of a camera.

    Parameters
    ----------
    found
        Changes to what is known, with errors.
    plumb
        Of `fall.sideways`.
    stated
        The set-up gives the scale; the estimate is then that of the markers against it.
    """
    views = len(known.camera.views)
    sigma = np.sqrt(np.diag(found.covariance))
    faults = slice(len(found.change) - FAULTS, len(found.change))
    change, error = found.change[faults], sigma[faults]
    turns = (
        ("mirror angle", MIRRORED.of(change[MIRROR], error[MIRROR]), "mirror-angle"),
        ("roll against the mirror", ROLLED.of(change[ROLL], error[ROLL]), "camera-roll"),
    )
    how = "turn of the markers in one view against the other"
    angles = [
        _fault(name, at, "rad", USEFUL_ANGLE_RAD, effect, how=how) for name, at, effect in turns
    ]
    return (
        *_scales(found, sigma, known, stated=stated),
        _aspect(found, slice(views, 2 * views)),
        *(angles if views > 1 else ()),
        _plumb("roll against gravity", plumb[0][0], plumb[1][0], "camera-roll"),
        _plumb("tilt against gravity", plumb[0][1], plumb[1][1], "gravity-direction"),
        _fault(
            "radial distortion",
            DISTORTED.of(change[DISTORTION], error[DISTORTION]),
            "1",
            USEFUL_DISTORTION,
            "radial-distortion",
            how="size and place in the frame; columns of one view against the other's",
        ),
        _nearness(known.camera.optics.nearness, change[NEARNESS], error[NEARNESS]),
    )


def _scales(
    found: PixelEstimate, sigma: Floats, known: Appearance, *, stated: bool
) -> list[Estimate]:
    scales, views = known.camera.optics.scales, known.camera.views
    own = math.hypot(sigma[0], SCALE_FLOOR)
    estimates = []
    for v, view in enumerate(views):
        shift = found.change[0] + (found.change[v] if v else 0.0)
        error = math.hypot(own, math.hypot(sigma[v], RATIO_FLOOR) if v else 0.0)
        value = scales[v] * math.exp(shift)
        estimates.append(
            Estimate(
                name=f"scale of the {view.value} view",
                value=value,
                sigma=value * error,
                unit="px/m",
                useful=value * USEFUL_SCALE,
                none=float(scales[v]) if stated else None,
                effect="image-scale",
                in_poses=not stated,
                how="markers that cross the disc, with the stated diameter; common to all shots",
            )
        )
    return estimates


def _aspect(pixels: PixelEstimate, stretches: slice) -> Estimate:
    weight = np.linalg.inv(pixels.covariance[stretches, stretches])
    variance = 1.0 / weight.sum()
    mean = variance * (weight @ pixels.change[stretches]).sum()
    found = ASPECT.of(mean, math.sqrt(variance))
    how = "rigid pattern of markers, longer along rows than along columns"
    return _fault("pixel aspect", found, "1", USEFUL_ASPECT, "pixel-aspect", how=how)


def _fault(
    name: str, found: tuple[float, float], unit: str, useful: float, effect: str, *, how: str
) -> Estimate:
    """Return the estimate of a camera fault that no pose parameter covers; expected value 0."""
    value, sigma = found
    return Estimate(name, value, sigma, unit, useful, 0.0, effect, in_poses=False, how=how)


def _plumb(name: str, value: float, sigma: float, effect: str) -> Estimate:
    found = float(value), math.hypot(sigma, PLUMB_FLOOR_RAD)
    how = "free fall before and after the contact"
    return _fault(name, found, "rad", USEFUL_PLUMB_RAD, effect, how=how)


def _nearness(known: float, change: float, sigma: float) -> Estimate:
    value = max(known + float(change), 0.0)
    floor = max(NEARNESS_FLOOR * value, NEARNESS_LEAST)
    return Estimate(
        name="perspective",
        value=value,
        sigma=math.hypot(sigma, floor),
        unit="1/m",
        useful=USEFUL_NEARNESS,
        none=0.0,
        effect="perspective",
        in_poses=True,
        how="columns of one view against the other's, by depth and height",
    )
