"""What a pusher does with its charge: the spheres as they leave the mouths of their tubes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple, dataclass, fields

import numpy as np

from analysis.arrays import Floats

LEAST_PRESSURE_KPA = 1e-3
"""A pusher never gets less, so that a trial friction above the pressure keeps a finite time."""
ALONG = np.array([1.0, -1.0])
"""Direction of flight along Y, of a and of b."""


@dataclass(frozen=True, slots=True)
class LaunchLaw:
    """Pushers without friction, and where the tubes stand; rig axes.

    Attributes
    ----------
    gain_a, gain_b
        v^2 = gain x pressure, m^2/s^2 for each kPa: 2 A L / m_eff, piston area A, stroke L.
    tilt_a_x, tilt_a_z, tilt_b_x, tilt_b_z
        Slope of each track at the mouth, toward +X and +Z for each unit of way.
    shift_x, shift_z
        Offset of track b from track a beyond the setting, m.
    height_x, height_z
        Mean of both tracks at the mouths, m.
    mouth
        Way along Y from each mouth to the middle between them, m: gravity acts on it.
    push
        Way at the muzzle's speed that takes as long as the push, m: twice the stroke when the push
        is uniform.
    middle
        Y of the middle between the mouths, m.
    """

    gain_a: float
    gain_b: float
    tilt_a_x: float = 0.0
    tilt_a_z: float = 0.0
    tilt_b_x: float = 0.0
    tilt_b_z: float = 0.0
    shift_x: float = 0.0
    shift_z: float = 0.0
    height_x: float = 0.0
    height_z: float = 0.0
    mouth: float = 0.05
    push: float = 0.02
    middle: float = 0.0

    @property
    def vector(self) -> Floats:
        """All numbers, shape (13,)."""
        return np.array(astuple(self))

    @property
    def tubes(self) -> tuple[float, float, float]:
        """All that tracing a touch back to the mouths depends on."""
        return self.mouth, self.push, self.middle


LAW_NAMES = tuple(field.name for field in fields(LaunchLaw))
LAW_UNITS = ("m2/s2/kPa",) * 2 + ("rad",) * 4 + ("m",) * 7
LAW_PRIOR_SIGMA = np.array([10.0] * 2 + [0.2] * 4 + [0.05] * 7)
"""Width of a prior about the defaults, zero for the gains: far wider than the errors of a campaign,
it fixes parameters that the settings do not vary."""


@dataclass(frozen=True, slots=True, eq=False)
class Charge:
    """Settings of S shots as they reach the pushers, spheres in the order a, b.

    Attributes
    ----------
    law
        Pushers and tubes.
    pressure_kpa
        Gauge pressure behind each pusher, shape (S, 2).
    offset_m
        Track b below track a, toward +X, shape (S,).
    delay_s
        Pusher b after pusher a, shape (S,).
    pressure_step
        Sign of the last change of each pressure, 0 before the first, shape (S, 2).
    slide_step
        Sign of the last move of the slide, shape (S,).
    waited_s
        Time from the charging to the pulse, zero where it is not known, shape (S,).
    radius_m
        Radii of the spheres, shape (2,).
    """

    law: LaunchLaw
    pressure_kpa: Floats
    offset_m: Floats
    delay_s: Floats
    pressure_step: Floats
    slide_step: Floats
    waited_s: Floats
    radius_m: Floats


SPEED, SLOPE, SPIN, OFFSET, HEIGHT, LAG = (
    slice(0, 2),
    slice(2, 6),
    slice(6, 12),
    slice(12, 14),
    slice(14, 16),
    slice(16, 17),
)
"""Where the numbers of a muzzle stand in a row."""
SIZE = 17


@dataclass(frozen=True, slots=True, eq=False)
class Muzzle:
    """Both spheres of S shots as they leave their mouths, a before b; rig axes.

    Attributes
    ----------
    speed
        Along the flight, m/s, shape (S, 2).
    slope
        Of the tracks toward +X and +Z for each unit of way, shape (S, 2, 2).
    spin
        rad/s, shape (S, 2, 3).
    offset_m
        Track b less track a, in X and Z, shape (S, 2).
    height_m
        Mean of both tracks, in X and Z, shape (S, 2).
    lag_s
        How much later than a the pusher of b starts, shape (S,).
    """

    speed: Floats
    slope: Floats
    spin: Floats
    offset_m: Floats
    height_m: Floats
    lag_s: Floats

    @property
    def row(self) -> Floats:
        """All numbers side by side, shape (S, 17)."""
        parts = (self.speed, self.slope, self.spin, self.offset_m, self.height_m, self.lag_s)
        return np.concatenate([part.reshape(len(self.lag_s), -1) for part in parts], axis=1)

    @classmethod
    def of_row(cls, row: Floats) -> Muzzle:
        """Return the muzzle of rows, shape (S, 17)."""
        return cls(
            speed=row[:, SPEED],
            slope=row[:, SLOPE].reshape(-1, 2, 2),
            spin=row[:, SPIN].reshape(-1, 2, 3),
            offset_m=row[:, OFFSET],
            height_m=row[:, HEIGHT],
            lag_s=row[:, LAG][:, 0],
        )


Launcher = Callable[[Charge], Muzzle]


def push(charge: Charge) -> Muzzle:
    """Launch without any loss: the work of the pressure is kinetic energy.

    v = sqrt(2 A L p / m_eff), spin zero, tracks where slide and tubes are.
    """
    law, shots = charge.law, len(charge.offset_m)
    gain = np.array([law.gain_a, law.gain_b])
    tilt = np.array([[law.tilt_a_x, law.tilt_a_z], [law.tilt_b_x, law.tilt_b_z]])
    pressure = np.maximum(charge.pressure_kpa, LEAST_PRESSURE_KPA)
    return Muzzle(
        speed=np.sqrt(np.maximum(gain, 1e-9) * pressure),
        slope=np.tile(tilt, (shots, 1, 1)),
        spin=np.zeros((shots, 2, 3)),
        offset_m=np.stack([charge.offset_m + law.shift_x, np.full(shots, law.shift_z)], axis=1),
        height_m=np.tile([law.height_x, law.height_z], (shots, 1)),
        lag_s=charge.delay_s,
    )
