"""Shots that were not fired yet: their state at first touch, and how sure it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.errors import LaunchRefusedError
from analysis.launch.predicted_touch import PredictedTouch
from analysis.launch.scatter import scatter_variance
from analysis.launch.settings import LaunchSettings
from analysis.launch.touch import NORMAL, TOUCH_POINT, states_of, tracks_meet
from analysis.model.predict.state import MOTION, POINT, SIZE, TILT, TIME, TURN_A, TURN_B, ShotStates

TURN_VARIANCE = (np.pi**2 / 3 + 2) / 3
"""Variance about each axis of an orientation that may be any, rad^2: the density of the angle is
(1 - cos a) / pi on 0 to pi, of the mean square pi^2 / 3 + 2."""
LEAST_SPEED = 0.05
"""Slower than this, m/s, nothing leaves a tube."""


@dataclass(frozen=True, slots=True)
class Limits:
    """What a rig allows: gauge pressure of each pusher in kPa, offset in mm, ends included."""

    pressure_kpa: tuple[float, float]
    offset_mm: tuple[float, float]

    def check(self, settings: LaunchSettings) -> None:
        """Refuse settings outside.

        Raises
        ------
        LaunchRefusedError
            With the shot, the value and the limits.
        """
        for name, values, (low, high), unit in (
            ("pressure a", settings.pressure_kpa[:, 0], self.pressure_kpa, "kPa"),
            ("pressure b", settings.pressure_kpa[:, 1], self.pressure_kpa, "kPa"),
            ("offset", settings.offset_m * 1e3, self.offset_mm, "mm"),
        ):
            # Millimetres through metres and back are rounded.
            spare = 1e-9 * max(abs(low), abs(high), 1.0)
            outside = ~((values >= low - spare) & (values <= high + spare))
            if outside.any():
                k = int(outside.argmax())
                raise LaunchRefusedError(
                    f"settings {k}: {name} of {values[k]:g} {unit}, the rig allows {low:g} to "
                    f"{high:g} {unit}"
                )


def check_meeting(predicted: PredictedTouch, settings: LaunchSettings) -> None:
    """Refuse settings that bring no collision.

    Raises
    ------
    LaunchRefusedError
        A pressure that leaves a sphere in its tube, or tracks that pass each other.
    """
    slow = predicted.muzzle.speed < LEAST_SPEED
    if slow.any():
        k, i = (int(index) for index in np.argwhere(slow)[0])
        raise LaunchRefusedError(
            f"settings {k}: {settings.pressure_kpa[k, i]:g} kPa leave sphere {'ab'[i]} in its tube"
        )
    past = ~tracks_meet(predicted.touch)
    if past.any():
        k = int(past.argmax())
        raise LaunchRefusedError(
            f"settings {k}: at an offset of {settings.offset_m[k] * 1e3:g} mm the spheres miss"
        )


@dataclass(frozen=True, slots=True, eq=False)
class Prediction:
    """S predicted shots.

    Attributes
    ----------
    predicted
        Muzzles, touches and derivatives.
    parameter_covariance, scatter
        Of the theory's parameters, shape (P, P), and of each kind of quantity, shape (K,).
    seen_s
        Instants of touch in the shots fitted, from their first frames: the trigger's affair, which
        is taken to stay as it was.
    """

    predicted: PredictedTouch
    parameter_covariance: Floats
    scatter: Floats
    seen_s: Floats

    @property
    def states(self) -> ShotStates:
        """Mean states at first touch; orientations are any, and stand unturned."""
        rows = self.predicted.touch
        return states_of(rows, np.full(len(rows), self.seen_s.mean()))

    @property
    def covariance(self) -> Floats:
        """Of the 24 numbers of `model.state` about `states`, shape (S, 24, 24)."""
        states = self.states
        normal = np.stack(states.tangents(), axis=-1)[:, [0, 2]]
        by_touch = np.zeros((len(normal), SIZE, 17))
        by_touch[:, MOTION, :12] = np.eye(12)
        by_touch[:, POINT, TOUCH_POINT] = np.eye(3)
        by_touch[:, TILT, NORMAL] = np.linalg.inv(normal)
        covariance = by_touch @ self._touch_covariance @ np.swapaxes(by_touch, 1, 2)
        covariance[:, TIME, TIME] = self.seen_s.var()
        for turn in (TURN_A, TURN_B):
            covariance[:, turn, turn] = TURN_VARIANCE * np.eye(3)
        return np.asarray(covariance)

    @property
    def _touch_covariance(self) -> Floats:
        """Of the numbers of the touch: H S H' + J P J', shape (S, 17, 17)."""
        forward, slope = self.predicted.by_muzzle, self.predicted.by_theory
        spread = scatter_variance(self.scatter, self.predicted.muzzle.speed)
        scattered = (forward * spread[:, None]) @ np.swapaxes(forward, 1, 2)
        return np.asarray(scattered + slope @ self.parameter_covariance @ np.swapaxes(slope, 1, 2))
