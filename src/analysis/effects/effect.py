"""An effect: one physical cause that the base model leaves out, in a form to fit and rank.

It names the stage between settings and image in which it acts, has a function that changes that
stage, and a description. At the `off` values of its parameters the function changes nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.operator import Body, Operator
from analysis.launch.muzzle import Launcher
from analysis.setup import CameraSetup

Values = NDArray[np.float64]
"""Values of an effect's parameters in their units, shape (parameters,)."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """One number of an effect.

    Attributes
    ----------
    symbol, unit, meaning
        As a table shows it.
    plausible
        Plausible range on this rig; outside it an effect is marked as implausible, never hidden.
    off
        Value at which the effect changes nothing.
    step
        A small change of it, for differences: far below what data can see, far above rounding.
    one_sided
        It cannot be less than `off`.
    possible
        Range outside which the effect has no meaning; a fit stays within.
    """

    symbol: str
    unit: str
    meaning: str
    plausible: tuple[float, float]
    off: float = 0.0
    step: float = 1e-5
    one_sided: bool = False
    possible: tuple[float, float] = (-np.inf, np.inf)


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect:
    """Description of any effect.

    Attributes
    ----------
    name
        Id in commands, files and the API.
    title
        The field's standard term.
    parameters
        What is fitted.
    formula, source
        The physics and where it comes from.
    gives_away
        Its signature in the residuals.
    confused_with
        Names of effects with a similar signature.
    contains
        Names of effects that are this one at some value of its parameters: it takes their place.
    variants
        The same effect with other values of its fixed constants, which a fit cannot find from the
        off value; the variant of the greatest likelihood represents the effect.
    of_pairs
        Whether it needs two spheres: it is not offered for a sphere on a plate.
    """

    stage: ClassVar[str]
    name: str
    title: str
    parameters: tuple[Parameter, ...]
    formula: str
    source: str
    gives_away: str
    confused_with: tuple[str, ...] = ()
    contains: tuple[str, ...] = ()
    variants: tuple[Effect, ...] = ()
    of_pairs: bool = False

    @property
    def off(self) -> Values:
        """Values at which the effect changes nothing."""
        return np.array([parameter.off for parameter in self.parameters])


@dataclass(frozen=True, slots=True, kw_only=True)
class LaunchEffect(Effect):
    """Changes what settings become at the muzzle: `wrap` turns a launcher into the changed one."""

    stage: ClassVar[str] = "launch"
    wrap: Callable[[Launcher, Values], Launcher]


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactEffect(Effect):
    """Changes what a contact leaves behind: `wrap` turns an operator into the changed one."""

    stage: ClassVar[str] = "contact"
    wrap: Callable[[Operator, Values], Operator]


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactLaw(Effect):
    """Puts another law in the place of the hard-sphere operator, with e and mu, without beta0.

    Effects of the contact wrap round it as they do round the operator. It has no values at which it
    changes nothing; what is scored beside the hard-sphere law is its share in a mixture of both.

    Attributes
    ----------
    law
        From the values of its parameters to the operator.
    stepped
        The same, integrated in so many steps; None: it is not integrated.
    shares
        Effects whose one parameter mixes the law, at typical values, into the operator: 0 is the
        operator, 1 the law.
    beside
        Laws that differ from it in the damping along the normal alone: where it is the likeliest,
        they are fitted from its values too.
    spread
        Of a fitted law: how far the parameters of the families that these shots do not tell from
        it lie from its own, root mean square, one for each. It is part of their errors.
    akin
        Those of its variants whose likeliest values lie near its own: they are looked for there.
    """

    stage: ClassVar[str] = "contact"
    law: Callable[[Values], Operator]
    stepped: Callable[[Values, int], Operator] | None = None
    shares: tuple[ContactEffect, ...] = ()
    beside: tuple[ContactLaw, ...] = ()
    spread: tuple[float, ...] = ()
    akin: tuple[ContactLaw, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Flying:
    """A sphere in free flight: centre (m), velocity (m/s), spin (rad/s), each of shape (..., 3).

    `partner` is the centre of the other sphere at the same time; None where there is none.
    """

    position: Floats
    velocity: Floats
    spin: Floats
    body: Body
    gravity: float
    air_density: float
    partner: Floats | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightEffect(Effect):
    """Adds an acceleration (m/s^2) and an angular acceleration (rad/s^2), shapes (..., 3).

    `nodes` is the number of instants of a flight at which it is evaluated: two suffice for a force
    that changes little on the way, one that falls off steeply needs more. `proportional`: both
    accelerations are proportional to the one parameter, so that one evaluation serves all values.
    """

    stage: ClassVar[str] = "flight"
    accelerate: Callable[[Flying, Values], tuple[Floats, Floats]]
    nodes: int = 2
    proportional: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraEffect(Effect):
    """Changes where the images show a centre: positions in rig axes, m, shape (..., 3)."""

    stage: ClassVar[str] = "camera"
    appear: Callable[[Floats, CameraSetup, Values], Floats]


@dataclass(frozen=True, slots=True, kw_only=True)
class OrientationEffect(Effect):
    """Changes how the images show orientations, alike in all frames.

    `turned` returns the rotation vectors by which those of a and b are seen turned, rad, rig axes,
    shape (2, 3).
    """

    stage: ClassVar[str] = "camera"
    turned: Callable[[Values], Floats]


@dataclass(frozen=True, slots=True, eq=False)
class Exposure:
    """When and where a frame shows a sphere.

    Attributes
    ----------
    times_s
        Stated time of each frame, shape (S, F).
    position
        Centres as predicted at the true times, m, shape (S, F, 2, 3).
    """

    times_s: Floats
    position: Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class ClockEffect(Effect):
    """Changes when a frame was exposed.

    `expose` returns true times by sphere: of each coordinate of the position, and of the
    orientation, in shapes that broadcast to (S, F, 2, 3) and (S, F, 2).
    """

    stage: ClassVar[str] = "clock"
    expose: Callable[[Exposure, CameraSetup, Values], tuple[Floats, Floats]]


@dataclass(frozen=True, slots=True, eq=False)
class Turning:
    """Where spheres are and how they are turned, S shots of F frames.

    Attributes
    ----------
    position
        Centres of mass as predicted from those of the outlines at first touch, m, (S, F, 2, 3).
    rotation, at_touch
        Orientations, body to rig axes, in the frames, (S, F, 2, 3, 3), and at first touch,
        (S, 2, 3, 3).
    """

    position: Floats
    rotation: Floats
    at_touch: Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyEffect(Effect):
    """Moves what is seen of a sphere with its turning: centres of outlines, m, (S, F, 2, 3).

    Orientations must be those of one body frame for each sphere through the whole campaign.
    """

    stage: ClassVar[str] = "body"
    displace: Callable[[Turning, Values], Floats]


@dataclass(frozen=True, slots=True, kw_only=True)
class ScatterEffect(Effect):
    """Adds noise that frames share instead of a shift; its one parameter is a standard deviation.

    `whiten` takes columns of whitened numbers (S, N, C) and the whitened change of the prediction
    for a unit of the disturbance of each frame, (S, F, N / F), and returns the columns whitened
    with the added noise.
    """

    stage: ClassVar[str] = "scatter"
    whiten: Callable[[Floats, Floats, Values], Floats]
