"""What a campaign is compared with: the collision law and the effects that have been added."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Floats
from analysis.collision.operator import Operator, WaltonLaw, walton
from analysis.effects.contact.plate_tilt import EFFECT as PLATE_TILT
from analysis.effects.contact.plate_tilt import leaning
from analysis.effects.effect import (
    BodyEffect,
    CameraEffect,
    ClockEffect,
    ContactEffect,
    ContactLaw,
    Effect,
    FlightEffect,
    OrientationEffect,
    Values,
)
from analysis.model.fitting.systematics import Systematic

LAW = ("e", "mu", "beta0")
BETA0 = LAW.index("beta0")
LAW_PRIOR = (0.74, 0.08, 0.6)
"""Where a fit starts: the thesis's nylon, with a beta0 that an elastic sphere could have."""
LAW_PRIOR_SIGMA = (1.0, 0.5, 0.7)
"""beta0 has no information without a shot that sticks, mu none without spins; a prior about the
start holds them. With any data to speak of it has no weight."""
_LAW_STEP = 1e-6
SLOPE_STEPS = 40
"""Of integration in an undamped contact, for differences."""
_HELD = 1e-4
"""Share of a stated error that is none."""


@dataclass(frozen=True, slots=True, eq=False)
class Active:
    """An effect that takes part, at some values of its parameters.

    Attributes
    ----------
    freed
        Errors of the measurement whose place it takes: they are no longer held to a stated size.
    """

    effect: Effect
    values: Values
    freed: tuple[Systematic, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Theory:
    """Law and effects; every parameter that all shots share, in one vector.

    Attributes
    ----------
    systematics
        Errors of the measurement, which take part in every theory of a campaign.
    active
        Effects that have been added.
    """

    law: WaltonLaw
    systematics: tuple[Systematic, ...] = ()
    active: tuple[Active, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each parameter: e, mu, beta0, then `effect.symbol`."""
        added = [f"{a.effect.name}.{p.symbol}" for a in self.parts for p in a.effect.parameters]
        return (*LAW, *added)

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each parameter."""
        return ("1",) * 3 + tuple(p.unit for a in self.parts for p in a.effect.parameters)

    @property
    def vector(self) -> Floats:
        """All parameters, shape (P,)."""
        law = [self.law.e, self.law.mu, self.law.beta0]
        return np.concatenate([law, *(a.values for a in self.parts)])

    @property
    def possible(self) -> tuple[Floats, Floats]:
        """Least and largest value of each parameter, shapes (P,)."""
        law = [(0.0, np.inf), (0.0, np.inf), (-np.inf, np.inf)]
        ranges = [*law, *(p.possible for a in self.parts for p in a.effect.parameters)]
        least, largest = zip(*ranges, strict=True)
        return np.array(least), np.array(largest)

    @property
    def steps(self) -> Floats:
        """A step for differences of each parameter, shape (P,)."""
        added = [p.step for a in self.parts for p in a.effect.parameters]
        return np.array([_LAW_STEP] * 3 + added)

    @property
    def parts(self) -> tuple[Systematic | Active, ...]:
        """Everything beside the law, in the order of the vector: systematics first."""
        return (*self.systematics, *self.active)

    @property
    def given(self) -> int:
        """Number of parameters that every theory of the campaign has: law and systematics."""
        return len(LAW) + sum(len(s.values) for s in self.systematics)

    @property
    def prior(self) -> tuple[Floats, Floats]:
        """What is known of each parameter beforehand: value and information, shapes (P,)."""
        centre, information = self.vector, np.zeros(len(self.names))
        centre[: len(LAW)] = LAW_PRIOR
        information[: len(LAW)] = np.array(LAW_PRIOR_SIGMA) ** -2
        start = len(LAW)
        for s in self.systematics:
            stop = start + len(s.values)
            centre[start:stop], information[start:stop] = s.stated, s.sigma**-2
            start = stop
        return centre, information

    @property
    def held(self) -> tuple[Floats, Floats]:
        """How the stated sizes of the systematics pull each parameter, and by what information.

        Shapes (P,), 0 for law and effects: shots that tell nothing of one leave it where it is.
        """
        centre, information = self.prior
        information[: len(LAW)] = 0.0
        return (centre - self.vector) * information, information

    @property
    def strain(self) -> float:
        """Chi-squared of the systematics against their stated sizes; each is one residual."""
        off = [((s.values - s.stated) / s.sigma) ** 2 for s in self.systematics]
        return float(sum(part.sum() for part in off))

    def unstrained(self, most_pull: float) -> Theory:
        """Return the theory with systematics that are pulled farther than that just as stated.

        Parameters
        ----------
        most_pull
            In stated errors.
        """
        kept = (
            s
            if (np.abs(s.values - s.stated) <= most_pull * s.sigma).all()
            else replace(s, values=s.stated)
            for s in self.systematics
        )
        return replace(self, systematics=tuple(kept))

    def at(self, vector: Floats) -> Theory:
        """Return the same theory at other values, shape (P,)."""
        sizes = np.cumsum([len(a.values) for a in self.parts])
        own = np.split(vector[len(LAW) :], sizes[:-1]) if len(sizes) else []
        count = len(self.systematics)
        return Theory(
            WaltonLaw(*map(float, vector[: len(LAW)])),
            tuple(replace(s, values=v) for s, v in zip(self.systematics, own, strict=False)),
            tuple(replace(a, values=v) for a, v in zip(self.active, own[count:], strict=True)),
        )

    def with_effect(self, effect: Effect, start: Values | None = None) -> Theory:
        """Return the theory with one more effect, at `start` or else where it is off.

        What the new effect contains, and an error of the measurement that it is, make room for it
        and hand on what their parameters are.
        """
        replaced = {effect.name, *effect.contains}
        parts: tuple[Systematic | Active, ...] = (*self.systematics, *self.active)
        room = [a for a in parts if a.effect.name in replaced]
        known = {
            p.symbol: v for a in room for p, v in zip(a.effect.parameters, a.values, strict=True)
        }
        if start is None:
            start = np.array([known.get(p.symbol, p.off) for p in effect.parameters])
        freed = tuple(a for a in room if isinstance(a, Systematic))
        freed += tuple(s for a in room if isinstance(a, Active) for s in a.freed)
        return replace(
            self,
            systematics=tuple(s for s in self.systematics if s.effect.name not in replaced),
            active=(
                *(a for a in self.active if a.effect.name not in replaced),
                Active(effect, start, freed),
            ),
        )

    def without_effect(self, name: str) -> Theory:
        """Return the theory less one effect; errors whose place it took are held again."""
        gone = [a for a in self.active if a.effect.name == name]
        held = tuple(replace(s, values=s.stated) for a in gone for s in a.freed)
        return replace(
            self,
            systematics=(*self.systematics, *held),
            active=tuple(a for a in self.active if a.effect.name != name),
        )

    def as_stated(self, name: str) -> Theory:
        """Return the theory less one effect, what it had set free being just as stated."""
        theory, known = self.without_effect(name), {s.effect.name for s in self.systematics}
        held = (
            s if s.effect.name in known else replace(s, sigma=_HELD * s.sigma)
            for s in theory.systematics
        )
        return replace(theory, systematics=tuple(held))

    @property
    def contact_law(self) -> ContactLaw | None:
        """Return the law that replaces the hard-sphere operator; None: the operator is used."""
        laws = (a.effect for a in self.active if isinstance(a.effect, ContactLaw))
        return next(laws, None)

    @property
    def operator(self) -> Operator:
        """The collision operator with all contact effects wrapped round it."""
        return self._operator(lambda law, values: law.law(values))

    @property
    def operator_of_slopes(self) -> Operator:
        """The same for differences: a law that is integrated needs fewer steps for them.

        Half as many change the slopes by less than a hundredth, and not where a fit ends.
        """
        return self._operator(
            lambda law, values: law.stepped(values, SLOPE_STEPS) if law.stepped else law.law(values)
        )

    def _operator(self, law_at: Callable[[ContactLaw, Values], Operator]) -> Operator:
        operator: Operator = walton
        for a in self.parts:
            if isinstance(a.effect, ContactLaw):
                operator = law_at(a.effect, a.values)
        for a in self.parts:
            if isinstance(a.effect, ContactEffect):
                operator = a.effect.wrap(operator, a.values)
        return operator

    def leaning(self, normal: Floats) -> Floats:
        """Return unit normals (S, 3) as the plate has them where there is one that may lean."""
        for part in self.systematics:
            if part.effect is PLATE_TILT:
                return leaning(normal, part.values)
        return normal

    @property
    def flight(self) -> tuple[tuple[FlightEffect, Values], ...]:
        """Effects of the flight."""
        return tuple((a.effect, a.values) for a in self.parts if isinstance(a.effect, FlightEffect))

    @property
    def camera(self) -> tuple[tuple[CameraEffect, Values], ...]:
        """Effects of the camera."""
        return tuple((a.effect, a.values) for a in self.parts if isinstance(a.effect, CameraEffect))

    @property
    def orientation(self) -> Floats | None:
        """Rotation vectors by which a and b are seen turned, rad, shape (2, 3); None: by none."""
        parts = ((a.effect, a.values) for a in self.parts)
        own = [e.turned(values) for e, values in parts if isinstance(e, OrientationEffect)]
        return np.sum(own, axis=0) if own else None

    @property
    def body(self) -> tuple[tuple[BodyEffect, Values], ...]:
        """Effects of the bodies' turning."""
        return tuple((a.effect, a.values) for a in self.parts if isinstance(a.effect, BodyEffect))

    @property
    def clock(self) -> tuple[tuple[ClockEffect, Values], ...]:
        """Effects of the clock."""
        return tuple((a.effect, a.values) for a in self.parts if isinstance(a.effect, ClockEffect))
