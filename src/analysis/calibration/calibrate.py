"""From the frames of a campaign to its camera: each number with its error and its effect."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.calibration.bending import DISTORTION, FAULTS, MIRROR, NEARNESS, ROLL
from analysis.calibration.estimate import Estimate
from analysis.calibration.pixel_estimates import PixelEstimate, estimate, normal_equations
from analysis.campaign import TEACHING_SHOTS, Campaign, ShotJob, read_job
from analysis.errors import InputError, ShotRefusedError
from analysis.imaging.stated_view import stated_view
from analysis.motion.poses import Centres
from analysis.motion.split import split_at_contact
from analysis.photometric.learn.appearance import Appearance
from analysis.photometric.method import followed_film
from analysis.photometric.render.sight import Equations
from analysis.photometric.result import tracking_of
from analysis.photometric.teaching import Taught, teach
from analysis.setup import Setup, without_exposure
from analysis.shot import check_frames

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


LEAST_FRAMES = 5
"""On one side of the contact: four determine nothing beyond a parabola and one residual."""


@dataclass(frozen=True, slots=True, eq=False)
class Fall:
    """Acceleration along Y and Z with their variances, m/s^2, shape (2,)."""

    acceleration: Floats
    variance: Floats


def falls_of(centres: tuple[Centres, Centres], times_s: Floats, gravity: float) -> list[Fall]:
    """Return the falls of both spheres before and after the contact of one shot.

    The frames next to the contact, which may show both motions, are left out. Without a contact
    there are none.
    """
    try:
        split = split_at_contact(*centres, times_s, gravity)
    except ShotRefusedError:
        return []
    sides = [(0, split - 1), (split + 1, len(times_s))]
    falls = [_fall(own, times_s, side) for own in centres for side in sides]
    return [fall for fall in falls if fall is not None]


def _fall(own: Centres, times_s: Floats, side: tuple[int, int]) -> Fall | None:
    chosen = (own.frames >= side[0]) & (own.frames < side[1])
    chosen &= np.isfinite(own.position).all(axis=1) & np.isfinite(own.sigma).all(axis=1)
    if chosen.sum() < LEAST_FRAMES:
        return None
    times = times_s[own.frames[chosen]]
    times = times - times.mean()
    design = np.stack([np.ones(len(times)), times, times**2 / 2], axis=1)
    values, variances = [], []
    for axis in (1, 2):
        sigma = own.sigma[chosen, axis]
        inverse = np.linalg.inv(design.T @ (design / sigma[:, None] ** 2))
        values.append((inverse @ design.T @ (own.position[chosen, axis] / sigma**2))[2])
        variances.append(inverse[2, 2])
    return Fall(np.array(values), np.array(variances))


def sideways(falls: Sequence[Fall], gravity: float) -> tuple[Floats, Floats]:
    """Return the angles of the fall from X toward Y and Z, rad, and their errors, shape (2,).

    Errors are enlarged to the scatter between the falls. Without falls: 0 with infinite errors.
    """
    if not falls:
        return np.zeros(2), np.full(2, np.inf)
    values = np.stack([fall.acceleration for fall in falls])
    weights = 1.0 / np.stack([fall.variance for fall in falls])
    mean = (weights * values).sum(axis=0) / weights.sum(axis=0)
    chi2 = (weights * (values - mean) ** 2).sum(axis=0) / max(len(falls) - 1, 1)
    sigma = np.sqrt(np.maximum(chi2, 1.0) / weights.sum(axis=0))
    return mean / gravity, sigma / gravity


LEAST_SHOTS = 3
"""From this number on, errors come from the scatter between shots."""
ALONE = 3.0
"""By how much the pixels' noise understates the errors of fewer shots."""


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """Camera parameters of a campaign.

    Attributes
    ----------
    estimates
        In the order of a table.
    used
        Shots that were used.
    refused
        The others, each with the reason.
    """

    estimates: tuple[Estimate, ...]
    used: tuple[int, ...]
    refused: dict[int, str]


def calibrate(
    campaign: Campaign, progress: Callable[[int, int], None] | None = None
) -> Calibration:
    """Estimate the parameters of the camera that filmed a campaign.

    Each shot contributes the estimate from its pixels with all else as nuisance parameters
    (`pixel_estimates`). Errors are those of the scatter between shots where that exceeds the noise.

    Parameters
    ----------
    campaign
        With frames, all shots under one set-up but for the exposure.
    progress
        Called with the number of shots done and of all shots.

    Raises
    ------
    InputError
        Shots under different set-ups, or none that can be used.
    """
    setup = _setup_of(campaign)
    known = teach(list(_first_shots(campaign.jobs, setup)))
    equations: list[tuple[Equations, Equations]] = []
    falls: list[Fall] = []
    used: list[int] = []
    refused: dict[int, str] = {}
    for count, job in enumerate(campaign.jobs, start=1):
        try:
            frames, times_s, _ = _frames(job, setup)
            if known is None:
                raise ShotRefusedError("assignment", "no spheres could be learned")
            film = followed_film(frames, times_s, known)
        except (InputError, ShotRefusedError) as refusal:
            refused[job.shot] = str(refusal)
            continue
        equations.append(normal_equations(film, known))
        centres = tracking_of(film, known, times_s, setup.environment.gravity_m_per_s2).centres
        falls += falls_of(centres, times_s, setup.environment.gravity_m_per_s2)
        used.append(job.shot)
        if progress is not None:
            progress(count, len(campaign.jobs))
    if known is None or not equations:
        first = next(iter(refused.items()))
        raise InputError(
            campaign.name, f"no shot can be used for calibration; shot {first[0]}: {first[1]}"
        )
    plumb = sideways(falls, setup.environment.gravity_m_per_s2)
    stated = setup.camera.scale_px_per_m is not None
    estimates = estimates_of(_with_scatter(equations, known), known, plumb, stated=stated)
    return Calibration(estimates, tuple(used), refused)


def _setup_of(campaign: Campaign) -> Setup:
    setups = {without_exposure(job.setup) for job in campaign.jobs}
    if len(setups) != 1:
        raise InputError(
            campaign.name,
            f"shots under {len(setups)} different set-ups; a camera is calibrated from one",
        )
    return setups.pop()


def _frames(job: ShotJob, setup: Setup) -> Taught:
    read = read_job(job)
    check_frames(read.frames, read.times_s, setup)
    frames, seen = stated_view(read.frames, setup)
    return frames, read.times_s - read.times_s[0], seen


def _first_shots(jobs: Sequence[ShotJob], setup: Setup) -> Iterator[Taught]:
    for job in jobs[:TEACHING_SHOTS]:
        with suppress(InputError, ShotRefusedError):
            yield _frames(job, setup)


def _with_scatter(equations: list[tuple[Equations, Equations]], known: Appearance) -> PixelEstimate:
    """Return the estimate of all shots; errors are at least those of the jackknife over shots."""
    whole = estimate(equations, known)
    if len(equations) < LEAST_SHOTS:
        return PixelEstimate(whole.change, whole.covariance * ALONE**2)
    parts = np.stack(
        [estimate(equations[:k] + equations[k + 1 :], known).change for k in range(len(equations))]
    )
    count = len(equations)
    scatter = (count - 1) / count * ((parts - parts.mean(axis=0)) ** 2).sum(axis=0)
    noise = np.diag(whole.covariance)
    enlarged = np.sqrt(np.maximum(scatter / noise, 1.0))
    return PixelEstimate(whole.change, whole.covariance * np.outer(enlarged, enlarged))
