"""From the frames of a campaign to its camera: each number with its error and its effect."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.calibration.estimate import Estimate
from analysis.calibration.pixel_estimates import PixelEstimate, estimate, normal_equations
from analysis.calibration.table import estimates_of
from analysis.campaign import TEACHING_SHOTS, Campaign, ShotJob, read_job
from analysis.errors import InputError, ShotRefusedError
from analysis.motion.poses import Centres
from analysis.motion.split import split_at_contact
from analysis.photometric.learn.appearance import Appearance
from analysis.photometric.method import Taught, followed_film, teach
from analysis.photometric.render.sight import Equations
from analysis.photometric.result import tracking_of
from analysis.setup import Setup, without_exposure
from analysis.shot import check_frames

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
    return read.frames, read.times_s - read.times_s[0], setup


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
