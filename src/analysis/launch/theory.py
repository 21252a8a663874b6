"""What the launches of a campaign are compared with: pushers, tubes, and the effects added."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import LaunchEffect, Values
from analysis.launch.muzzle import (
    LAW_NAMES,
    LAW_PRIOR_SIGMA,
    LAW_UNITS,
    Charge,
    Launcher,
    LaunchLaw,
    Muzzle,
    push,
)
from analysis.launch.settings import LaunchSettings
from analysis.launch.touch import Ground, touch

_LAW_STEP = 1e-6
LAW_SIZE = len(LAW_NAMES)


@dataclass(frozen=True, slots=True, eq=False)
class ActiveLaunch:
    """A launch effect that takes part, at some values of its parameters."""

    effect: LaunchEffect
    values: Values


@dataclass(frozen=True, slots=True, eq=False)
class LaunchTheory:
    """Law and effects; every parameter in one vector of shape (P,)."""

    law: LaunchLaw
    active: tuple[ActiveLaunch, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each parameter: those of the law, then `effect.symbol`."""
        added = [f"{a.effect.name}.{p.symbol}" for a in self.active for p in a.effect.parameters]
        return (*LAW_NAMES, *added)

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each parameter."""
        return (*LAW_UNITS, *(p.unit for a in self.active for p in a.effect.parameters))

    @property
    def vector(self) -> Floats:
        """All parameters."""
        return np.concatenate([self.law.vector, *(a.values for a in self.active)])

    @property
    def steps(self) -> Floats:
        """A step for differences of each parameter."""
        return np.array(
            [_LAW_STEP] * LAW_SIZE + [p.step for a in self.active for p in a.effect.parameters]
        )

    @property
    def prior(self) -> tuple[Floats, Floats]:
        """Centre and width of the weak prior; an effect's width is its plausible range."""
        parameters = [p for a in self.active for p in a.effect.parameters]
        centre = np.concatenate([LaunchLaw(0.0, 0.0).vector, [p.off for p in parameters]])
        width = np.array([p.plausible[1] - p.plausible[0] for p in parameters])
        return centre, np.concatenate([LAW_PRIOR_SIGMA, width])

    def at(self, vector: Floats) -> LaunchTheory:
        """Return the same theory at other values."""
        start, active = LAW_SIZE, []
        for a in self.active:
            stop = start + len(a.values)
            active.append(replace(a, values=vector[start:stop]))
            start = stop
        return LaunchTheory(LaunchLaw(*map(float, vector[:LAW_SIZE])), tuple(active))

    def with_effect(self, effect: LaunchEffect) -> LaunchTheory:
        """Return the theory with one more effect, at the values where it is off."""
        return replace(self, active=(*self.active, ActiveLaunch(effect, effect.off)))

    def launch(self, settings: LaunchSettings, ground: Ground) -> Muzzle:
        """Return both spheres of every shot at their mouths."""
        launcher: Launcher = push
        for a in self.active:
            launcher = a.effect.wrap(launcher, a.values)
        radius = np.array([body.radius for body in ground.bodies])
        return launcher(Charge(law=self.law, radius_m=radius, **settings.charge))

    def touch(self, settings: LaunchSettings, ground: Ground) -> Floats:
        """Return every shot at first touch, shape (S, 17)."""
        return touch(self.launch(settings, ground), self.law, ground)
