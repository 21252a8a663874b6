"""What a campaign may hide: switches of nature, at strengths that a laboratory would meet."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from simulators.challenge.nature import Nature
from simulators.challenge.unnamed import LAWS, Dependence

Switch = Callable[[Nature, float], Nature]


@dataclass(frozen=True, slots=True)
class Hidden:
    """One effect that a campaign may hide.

    Parameters
    ----------
    name
        The catalogue's name; of something that no catalogue has, a name of its own.
    amplitude, unit, meaning
        How large it is at full strength, and what that number says.
    acts_on
        Two effects on the same are never hidden together.
    switch
        Turns it on in a nature, by an amplitude.
    either_sign
        The sign is drawn.
    faint
        A quarter of it is lost in the noise of 120 shots, and is not drawn.
    subtle
        All of it leaves the error of 120 shots within a tenth of the noise: nothing for a beginner.
    known
        False: no catalogue has it, and the right answer is `unexplained`.
    like
        Names that such shots cannot be relied on to tell from it.
    beside
        Names that may stand beside it in an answer, as it contains them.
    law
        What depends on what, and how: slot, argument and shape of what no catalogue has.
    """

    name: str
    amplitude: float
    unit: str
    meaning: str
    acts_on: str
    switch: Switch
    either_sign: bool = False
    faint: bool = False
    subtle: bool = False
    known: bool = True
    like: tuple[str, ...] = ()
    beside: tuple[str, ...] = ()
    law: tuple[str, str, str] | None = None


def _field(name: str) -> Switch:
    def switch(nature: Nature, amplitude: float) -> Nature:
        changes: Mapping[str, float] = {name: amplitude}
        return replace(nature, **changes)  # type: ignore[arg-type]  # a field of plain numbers

    return switch


def _wind(nature: Nature, amplitude: float) -> Nature:
    wind = (0.0, 0.8 * amplitude, 0.6 * amplitude)
    return replace(nature, drag_coefficient=_DRAG_COEFFICIENT, wind_m_per_s=wind)


def _tilted(nature: Nature, amplitude: float) -> Nature:
    return replace(nature, gravity_tilt_rad=(0.8 * amplitude, 0.6 * amplitude))


def _following(name: str) -> Switch:
    def switch(nature: Nature, amplitude: float) -> Nature:
        return replace(nature, dependence=Dependence(LAWS[name], amplitude))

    return switch


_DRAG_COEFFICIENT = 0.45
_FALLING = ("restitution-viscoelastic", "restitution-plastic", "restitution-yield-knee")

_ALL = (
    Hidden(
        "restitution-viscoelastic",
        1.0,
        "1",
        "share of a fully viscoelastic loss at 2 m/s",
        "e(v)",
        _field("viscosity"),
        like=_FALLING,
    ),
    Hidden(
        "restitution-plastic",
        0.06,
        "1",
        "exponent of the fall of e with speed",
        "e(v)",
        _field("restitution_power"),
        like=_FALLING,
    ),
    Hidden(
        "restitution-obliquity",
        0.03,
        "1",
        "relative change of e for each unit of v_s/v_n",
        "e(v)",
        _field("restitution_obliquity"),
        either_sign=True,
    ),
    Hidden(
        "restitution-drift",
        0.03,
        "1",
        "relative change of e over the campaign",
        "e(t)",
        _field("restitution_drift"),
        either_sign=True,
    ),
    Hidden(
        "friction-drift",
        0.3,
        "1",
        "relative change of mu over the campaign",
        "mu(t)",
        _field("friction_drift"),
        either_sign=True,
    ),
    Hidden(
        "friction-speed",
        0.1,
        "1",
        "relative change of mu at 1 m/s for each factor of e in slip speed",
        "mu(v)",
        _field("friction_speed"),
        either_sign=True,
    ),
    Hidden(
        "inertia-factor",
        0.08,
        "1",
        "relative excess of the moments of inertia",
        "bodies",
        _field("inertia_excess"),
        either_sign=True,
    ),
    Hidden(
        "mass-mismatch",
        0.01,
        "1",
        "(m_a - m_b) / (m_a + m_b)",
        "bodies",
        _field("mass_difference"),
        either_sign=True,
        like=("radius-mismatch",),
    ),
    Hidden(
        "torsional-friction",
        0.0008,
        "m",
        "radius of the contact spot at 2 m/s",
        "spin",
        _field("torsion_radius_m"),
    ),
    Hidden(
        "finite-contact",
        1.0,
        "1",
        "duration in units of Hertz, E = 3 GPa, nu = 0.4",
        "duration",
        _field("softness"),
    ),
    Hidden(
        "tangential-compliance",
        1.0,
        "1",
        "share of the impulse that comes through springs",
        "mu(v)",
        _field("compliance"),
        subtle=True,
    ),
    Hidden(
        "drag",
        _DRAG_COEFFICIENT,
        "1",
        "drag coefficient",
        "air",
        _field("drag_coefficient"),
        faint=True,
        like=("wind",),
    ),
    Hidden(
        "wind",
        1.2,
        "m/s",
        "speed of the air, 0.8 of it toward +Y and 0.6 toward +Z",
        "air",
        _wind,
        faint=True,
        like=("drag",),
        beside=("drag",),
    ),
    Hidden(
        "magnus-lift",
        1.0,
        "1",
        "share of the lift that the coefficient of sports balls gives",
        "air",
        _field("lift"),
        faint=True,
        subtle=True,
    ),
    Hidden(
        "gravity-direction",
        0.02,
        "rad",
        "tilt of the vertical, 0.8 of it toward +Y and 0.6 toward +Z",
        "vertical",
        _tilted,
        either_sign=True,
        subtle=True,
    ),
    Hidden(
        "image-scale",
        0.005,
        "1",
        "relative excess of lengths in the image",
        "scale",
        _field("image_scale"),
        either_sign=True,
        like=("radius-mismatch",),
    ),
    Hidden(
        "frame-rate",
        0.003,
        "1",
        "relative excess of the true frame interval",
        "scale",
        _field("frame_rate"),
        either_sign=True,
        faint=True,
        like=("gravity-value", "buoyancy"),
    ),
    Hidden(
        "pixel-aspect",
        0.01,
        "1",
        "relative excess of rows over columns",
        "pixels",
        _field("pixel_aspect"),
        either_sign=True,
    ),
    Hidden(
        "mirror-angle",
        0.01,
        "rad",
        "turn of the mirror about Y",
        "mirror",
        _field("mirror_rad"),
        either_sign=True,
        subtle=True,
    ),
    Hidden(
        "camera-roll",
        0.0175,
        "rad",
        "turn of the picture",
        "vertical",
        _field("roll_rad"),
        either_sign=True,
    ),
    Hidden(
        "radial-distortion",
        0.02,
        "1",
        "relative excess of the radius at the corner",
        "pixels",
        _field("distortion"),
        either_sign=True,
    ),
    Hidden(
        "attraction",
        20.0,
        "m/s^2",
        "acceleration toward each other at touch, fading over 8 mm",
        "air",
        _field("pull_m_per_s2"),
        known=False,
        law=("flight", "distance", "exponential"),
    ),
    Hidden(
        "camera-vibration",
        0.1,
        "px",
        "amplitude along the rows, 120 Hz",
        "pixels",
        _field("shake_px"),
        known=False,
    ),
    Hidden(
        "restitution-temperature",
        0.008,
        "1/K",
        "relative change of e with the temperature of the room",
        "e(t)",
        _field("restitution_per_kelvin"),
        either_sign=True,
        known=False,
        law=("e", "temperature_c", "linear"),
    ),
)

_FORMED = (
    Hidden(
        "attraction-power",
        10.0,
        "m/s^2",
        "acceleration toward each other at touch, falling as 1/d^4",
        "air",
        _field("central_m_per_s2"),
        either_sign=True,
        known=False,
        law=("flight", "distance", "power"),
    ),
    *(
        Hidden(
            name,
            law.amplitude,
            law.unit,
            law.meaning,
            f"{law.slot}(law)",
            _following(name),
            either_sign=True,
            known=False,
            law=(law.slot, law.argument, law.shape),
        )
        for name, law in LAWS.items()
    ),
)

FORMED: Mapping[str, Hidden] = MappingProxyType({effect.name: effect for effect in _FORMED})
"""Laws that no catalogue holds, by name."""

HIDDEN: Mapping[str, Hidden] = MappingProxyType({e.name: e for e in (*_ALL, *_FORMED)})
"""Every effect that may be hidden, by name."""

STRENGTHS: Mapping[str, float] = MappingProxyType({"full": 1.0, "quarter": 0.25})
"""Factor on the amplitudes, by name."""


def switched(amplitudes: Mapping[str, float]) -> Nature:
    """Return the plain nature with the named effects on, at these amplitudes."""
    nature = Nature()
    for name, amplitude in amplitudes.items():
        nature = HIDDEN[name].switch(nature, amplitude)
    return nature
