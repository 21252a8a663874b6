"""Shots that could be fired: settings within the rig's limits, and what a shot there would show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.errors import LaunchRefusedError
from analysis.launch.predicted_touch import predict_touch
from analysis.launch.prediction import LEAST_SPEED, Limits
from analysis.launch.result import LaunchFit
from analysis.launch.settings import OFFSET, PRESSURES, LaunchSettings
from analysis.launch.touch import TOUCH_POINT, tracks_meet
from analysis.model.data.inside import without_contact_frames
from analysis.model.data.poses import PoseData
from analysis.model.data.unseen import spins_unknown
from analysis.model.fitting.fit import Fit
from analysis.model.predict.prediction import predict
from analysis.model.predict.state import SIZE, Kick, ShotStates
from analysis.model.predict.theory import Theory

PRESSURE_LEVELS, OFFSET_LEVELS = 6, 9
COARSE, FINE = 3, 40
"""Shots drawn at each setting: what a shot shows is averaged over the scatter of the launch. A few
find the settings; what many shots at one setting show needs more draws than a shot has numbers, or
its rival would follow the few."""
PRESSURE_ROUNDING_KPA, OFFSET_ROUNDING_MM = 0.5, 0.1
AFTER_THE_CAMPAIGN = 0.5
"""Place in the order of firing: next shots come last."""


@dataclass(frozen=True, slots=True, order=True)
class Setting:
    """Gauge pressures of both pushers in kPa, and tube b below tube a in mm."""

    pressure_a_kpa: float
    pressure_b_kpa: float
    offset_mm: float


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """Settings that bring collisions in view, and shots drawn there.

    Attributes
    ----------
    settings
        K settings.
    data
        Frames, sigmas and covariates of K x D shots, those of a setting together. Their poses are
        still to be foretold (`foreseen`).
    states
        Of these shots at first touch.
    """

    settings: tuple[Setting, ...]
    data: PoseData
    states: ShotStates

    @property
    def draws(self) -> int:
        """Shots at each setting D."""
        return len(self.data.shots) // len(self.settings)

    def averaged(self, by_shot: Floats) -> Floats:
        """Average what shots give (K x D, ...) over the draws of each setting, (K, ...)."""
        parted = by_shot.reshape(len(self.settings), self.draws, *by_shot.shape[1:])
        return np.asarray(parted.mean(axis=1))

    def spread(self, counts: Floats) -> Floats:
        """Share the shots at each setting (K,) out to its draws, (K x D,)."""
        return np.repeat(counts / self.draws, self.draws)


def grid(limits: Limits, *, alike: bool = False) -> list[Setting]:
    """Return settings spread evenly over what the rig allows.

    Parameters
    ----------
    alike
        Whether both pushers take the same pressure.
    """
    pressures = _levels(limits.pressure_kpa, PRESSURE_LEVELS, PRESSURE_ROUNDING_KPA)
    offsets = _levels(limits.offset_mm, OFFSET_LEVELS, OFFSET_ROUNDING_MM)
    pairs = [(a, b) for a in pressures for b in pressures if a == b or not alike]
    return [Setting(a, b, offset) for a, b in pairs for offset in offsets]


def candidates(
    data: PoseData,
    fit: Fit,
    launch: LaunchFit,
    settings: Sequence[Setting],
    draws: int = COARSE,
) -> Candidates:
    """Draw shots at every setting where the spheres meet in view.

    A shot has the frames and sigmas of the campaign's shots that are nearest in speed, and the
    campaign's medians of all other covariates.

    Parameters
    ----------
    data, fit, launch
        The campaign, a fit of its poses, and the fit of its launches.
    draws
        Shots at each setting. All settings share them, so that they differ by themselves alone.

    Raises
    ------
    LaunchRefusedError
        There is no such setting.
    """
    asked = _launch_settings(settings, launch)
    usable = _in_view(asked, fit, launch)
    if not usable.any():
        raise LaunchRefusedError("at no setting that the rig allows the spheres meet in view")
    chosen = tuple(s for s, good in zip(settings, usable, strict=True) if good)
    foretold = launch.predict(asked.of_shots(usable))
    root = _root(foretold.covariance)
    drawn = np.einsum("kij,dj->kdi", root, _scatter(draws))
    each = np.repeat(np.arange(len(chosen)), draws)
    like = _nearest(foretold.states, fit.states, draws).ravel()
    states = _of(foretold.states, each).moved(drawn.reshape(-1, SIZE))
    states = replace(states, time_s=fit.states.time_s[like])
    frames = _frames_like(data, like, [chosen[k] for k in each])
    if fit.states.kick is not None:
        states = replace(states, kick=Kick(np.zeros((len(each), 3)), spins_unknown(frames)))
    return Candidates(chosen, frames, states)


def foreseen(data: PoseData, states: ShotStates, theory: Theory) -> PoseData:
    """Return the data with the poses that a theory foretells, free of noise."""
    poses = predict(data, states, theory)
    return replace(data, position=poses.position, rotation=poses.rotation)


def foreseen_shots(drawn: Candidates, theory: Theory) -> PoseData:
    """Return the drawn shots as a theory foretells them, frames inside contact left out."""
    return without_contact_frames(foreseen(drawn.data, drawn.states, theory))


def _levels(bounds: tuple[float, float], count: int, rounding: float) -> list[float]:
    low, high = bounds
    levels = np.clip(np.round(np.linspace(low, high, count) / rounding) * rounding, low, high)
    return sorted({float(round(level, 6)) for level in levels})


def _launch_settings(settings: Sequence[Setting], launch: LaunchFit) -> LaunchSettings:
    """Return settings as the launch knows them; from which side they are reached is left open."""
    none = np.zeros(len(settings))
    return LaunchSettings(
        pressure_kpa=np.array([[s.pressure_a_kpa, s.pressure_b_kpa] for s in settings]),
        offset_m=np.array([s.offset_mm for s in settings]) * 1e-3,
        delay_s=none,
        pressure_step=np.zeros((len(settings), 2)),
        slide_step=none,
        waited_s=np.full(len(settings), np.median(launch.settings.waited_s)),
    )


def _in_view(settings: LaunchSettings, fit: Fit, launch: LaunchFit) -> NDArray[np.bool_]:
    """Return where spheres leave their tubes and meet where the camera sees them, shape (K,).

    That is within a radius of where contacts were seen.
    """
    foretold = predict_touch(launch.theory, settings, launch.touches.ground)
    point = foretold.touch[:, TOUCH_POINT]
    spare = launch.touches.ground.bodies[0].radius
    low, high = fit.states.point.min(axis=0) - spare, fit.states.point.max(axis=0) + spare
    inside = ((point > low) & (point < high)).all(axis=1)
    leaving = (foretold.muzzle.speed >= LEAST_SPEED).all(axis=1)
    return np.asarray(inside & leaving & tracks_meet(foretold.touch))


def _root(covariance: Floats) -> Floats:
    """Return a root of covariances that may be singular, shape (K, 24, 24)."""
    scale = np.sqrt(np.maximum(np.diagonal(covariance, axis1=1, axis2=2), 1e-300))
    values, vectors = np.linalg.eigh(covariance / scale[:, :, None] / scale[:, None, :])
    root = vectors * np.sqrt(np.clip(values, 0.0, None))[:, None, :] @ np.swapaxes(vectors, 1, 2)
    return np.asarray(scale[:, :, None] * root)


def _scatter(draws: int) -> Floats:
    """Return drawn standard normals (D, 24), of unit covariance if there are enough of them."""
    drawn = np.random.default_rng(0).standard_normal((draws, SIZE))
    if draws <= SIZE:
        return drawn
    drawn -= drawn.mean(axis=0)
    root = np.linalg.cholesky(drawn.T @ drawn / draws)
    return np.asarray(np.linalg.solve(root, drawn.T).T)


def _nearest(asked: ShotStates, seen: ShotStates, draws: int) -> NDArray[np.intp]:
    """Return the campaign's shots that are nearest in speed to each setting, shape (K, D).

    No more of them than a few, taken in turn.
    """
    speeds = [
        np.linalg.norm(states.before.velocity_b - states.before.velocity_a, axis=1)
        for states in (asked, seen)
    ]
    order = np.argsort(np.abs(speeds[0][:, None] - speeds[1]), axis=1, kind="stable")
    return order[:, np.arange(draws) % min(COARSE, order.shape[1])]


def _of(states: ShotStates, index: NDArray[np.intp]) -> ShotStates:
    return ShotStates.joined([states.of_shots(slice(k, k + 1)) for k in index])


def _frames_like(data: PoseData, like: NDArray[np.intp], settings: Sequence[Setting]) -> PoseData:
    """Return shots with the frames of others, at settings of their own."""
    count = len(like)
    covariates = {name: np.full(count, np.median(v)) for name, v in data.covariates.items()}
    covariates["order"] = np.full(count, AFTER_THE_CAMPAIGN)
    for k, name in enumerate(PRESSURES):
        covariates[name] = np.array([(s.pressure_a_kpa, s.pressure_b_kpa)[k] for s in settings])
    covariates[OFFSET] = np.array([s.offset_mm for s in settings])
    arrays = ("times_s", "position", "position_sigma", "rotation", "rotation_sigma")
    return replace(
        data,
        **{name: getattr(data, name)[like] for name in arrays},
        turn_shape=None,
        shots=np.arange(count, dtype=np.intp),
        covariates=covariates,
    )
