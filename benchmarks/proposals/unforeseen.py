"""Worlds that were not built for the proposals: other grammar, two slots, other settings.

What is claimed of each stands beside what is true there. An answer is true where every slot that
is named follows something in this world, and what it is said to follow is what it follows, or is
named among what is alike.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.poses import PoseData
from analysis.model.proposals.propose import propose
from analysis.model.proposals.proposed import Proposed
from benchmarks.discovery.campaigns import STATED, posed
from benchmarks.discovery.lasting import PLAIN, lasting_campaign
from simulators.challenge.campaign import run_campaign
from simulators.challenge.launch import Settings, Touch
from simulators.challenge.nature import Nature
from simulators.challenge.unnamed import Dependence, Law

Floats = NDArray[np.float64]
Change = Callable[[Settings, Touch, float], Floats]
Group = tuple[str, str]

HARD = Nature()
LASTING = frozenset({"lasting-contact"})
"""Of contacts that last, beside which a law is hidden."""


@dataclass(frozen=True, slots=True)
class World:
    """What some coefficients follow, and how.

    Attributes
    ----------
    told
        In words.
    changes
        Relative change of each slot.
    true
        Slots and arguments that may be named: the first ones are what is hidden, the others say the
        same in this world.
    effects
        Names of effects of the catalogue that say the same.
    warmth
        By what the swings of the room's temperature are multiplied.
    nature
        What the spheres obey beside it.
    """

    told: str
    changes: Mapping[str, Change]
    true: frozenset[Group] = frozenset()
    effects: frozenset[str] = frozenset()
    warmth: float = 1.0
    nature: Nature = HARD


@dataclass(frozen=True, slots=True)
class Follows(Dependence):
    """Coefficients that follow something in a world of one's own."""

    changes: Mapping[str, Change]

    def factor(self, slot: str, settings: Settings, touch: Touch, radius_m: float) -> Floats:
        """Return by what a coefficient of the plain theory is multiplied, (S,)."""
        if slot not in self.changes:
            return np.ones(len(settings.offset_mm))
        return 1.0 + self.changes[slot](settings, touch, radius_m)


def _slip(touch: Touch, radius_m: float) -> Floats:
    return np.asarray(np.linalg.norm(touch.slip(radius_m), axis=1))


def _warm(settings: Settings) -> Floats:
    return np.asarray(settings.temperature_c - 23.0)


def _whirl(touch: Touch) -> Floats:
    relative = np.einsum("si,si->s", touch.spin[:, 1] - touch.spin[:, 0], touch.normal)
    return np.asarray(np.abs(relative))


def _angle(touch: Touch) -> Floats:
    return np.asarray(np.arctan2(touch.normal[:, 0], touch.normal[:, 1]))


_E_SPEED, _E_TEMPERATURE = ("e", "speed_n"), ("e", "temperature_c")
_MU_SLIP, _MU_TEMPERATURE = ("mu", "speed_s"), ("mu", "temperature_c")
_SAME_SPEEDS = frozenset(
    {"restitution-viscoelastic", "restitution-plastic", "restitution-yield-knee"}
)

WORLDS: Mapping[str, World] = MappingProxyType(
    {
        "gaussian": World(
            "e falls as exp(-(v_n / 12)^2)",
            {"e": lambda s, t, r: np.exp(-((t.approach / 12.0) ** 2)) - 1.0},
            frozenset({_E_SPEED}),
            _SAME_SPEEDS,
        ),
        "saturating": World(
            "mu rises as tanh(v_s / (2 m/s))",
            {"mu": lambda s, t, r: 0.4 * np.tanh(_slip(t, r) / 2.0)},
            frozenset({_MU_SLIP}),
            frozenset({"friction-speed"}),
        ),
        "two-slots": World(
            "e and mu both follow the temperature",
            {"e": lambda s, t, r: 0.006 * _warm(s), "mu": lambda s, t, r: -0.08 * _warm(s)},
            frozenset({_E_TEMPERATURE, _MU_TEMPERATURE}),
        ),
        "two-arguments": World(
            "e follows speed in a bump and the order in a wave",
            {
                "e": lambda s, t, r: (
                    0.01 * np.exp(-0.5 * ((t.approach - 4.0) / 0.7) ** 2)
                    + 0.008 * np.sin(12.0 * s.order)
                )
            },
            frozenset({_E_SPEED, ("e", "order")}),
        ),
        "barely-varied": World(
            "mu follows a temperature that swings by 0.05 K",
            {"mu": lambda s, t, r: 2.0 * _warm(s)},
            frozenset({_MU_TEMPERATURE}),
            warmth=0.05,
        ),
        "days": World(
            "e is another on each of three days",
            {"e": lambda s, t, r: 0.01 * np.array([0.0, 1.0, -0.5])[_day(s)]},
            frozenset({("e", "order")}),
            frozenset({"restitution-drift"}),
        ),
        "four-fold": World(
            "e follows four times the angle of the normal",
            {"e": lambda s, t, r: 0.02 * np.cos(4.0 * _angle(t))},
            frozenset(
                {("e", "normal"), ("e", "obliquity"), ("e", "offset_mm"), ("e", "contact_x")}
            ),
        ),
        "energy": World(
            "e falls with the whole kinetic energy, v_n^2 + v_s^2",
            {"e": lambda s, t, r: -0.0015 * (t.approach**2 + _slip(t, r) ** 2)},
            frozenset({_E_SPEED, ("e", "speed_s"), ("e", "speed_n*speed_s")}),
            _SAME_SPEEDS,
        ),
        "spin-saturates": World(
            "mu falls as 1 / (1 + |w_n| / (60 rad/s))",
            {"mu": lambda s, t, r: 0.3 / (1.0 + _whirl(t) / 60.0)},
            frozenset({("mu", "spin")}),
        ),
        "warm-and-fast": World(
            "e follows the temperature times ln(v_n / (1 m/s)), which is never zero",
            {"e": lambda s, t, r: 0.002 * _warm(s) * np.log(t.approach)},
            frozenset({("e", "speed_n*temperature_c")}),
        ),
        "lasting-temperature": World(
            "e follows the temperature in contacts that last",
            {"e": lambda s, t, r: 0.004 * _warm(s)},
            frozenset({_E_TEMPERATURE}),
            LASTING,
            nature=PLAIN,
        ),
        "lasting-bump": World(
            "e follows speed in a bump in contacts that last",
            {"e": lambda s, t, r: 0.01 * np.exp(-0.5 * ((t.approach - 4.0) / 0.7) ** 2)},
            frozenset({_E_SPEED}),
            LASTING,
            nature=PLAIN,
        ),
        "lasting-spin": World(
            "mu falls as 1 / (1 + |w_n| / (60 rad/s)) in contacts that last",
            {"mu": lambda s, t, r: 0.3 / (1.0 + _whirl(t) / 60.0)},
            frozenset({("mu", "spin")}),
            LASTING,
            nature=PLAIN,
        ),
        "lasting-nothing": World("nothing is missing but that contacts last", {}, nature=PLAIN),
        "nothing": World("nothing is missing", {}),
    }
)
"""By name."""


def _day(settings: Settings) -> NDArray[np.intp]:
    return np.minimum(((settings.order + 0.5) * 3).astype(np.intp), 2)


def fired(world: World, seed: int, shots: int) -> PoseData:
    """Return the poses of a campaign in a world."""
    law = Law("", "", "", lambda s, t, r: np.zeros(len(s.offset_mm)), "1", world.told, 0.0)
    calm = world.changes
    if world.warmth != 1.0:
        calm = {slot: _calmed(change, world.warmth) for slot, change in calm.items()}
    follows = Follows(law, 0.0, calm)
    nature = replace(world.nature, dependence=follows)
    if world.nature.forces is not None:
        return lasting_campaign(nature, seed, shots)
    data = posed(run_campaign(nature, seed, shots=shots, noise=STATED))
    if world.warmth != 1.0:
        warm = data.covariates["temperature_c"]
        noted = {**data.covariates, "temperature_c": 23.0 + world.warmth * (warm - 23.0)}
        return replace(data, covariates=noted)
    return data


def _calmed(change: Change, warmth: float) -> Change:
    """Return what follows a temperature that swings less than the simulator's."""

    def calm(settings: Settings, touch: Touch, radius_m: float) -> Floats:
        return warmth * change(settings, touch, radius_m)

    return calm


def claimed(data: PoseData) -> tuple[Proposed, list[Group], list[set[Group]]]:
    """Return what is proposed, the groups named, and of each what may be meant as well."""
    found = propose(data, (), CATALOGUE)
    claims = [(one.form.group, one.alike) for one in found.accepted]
    claims += [(law.form.group, law.alike) for law in found.launch]
    return found, [group for group, _ in claims], [{group, *alike} for group, alike in claims]


def is_true(world: World, found: Proposed, meant: list[set[Group]]) -> bool:
    """Whether every claim holds in this world, and what is hidden was not passed over."""
    known = set(found.effects)
    if not world.changes:
        return not meant and known <= (LASTING if world.nature.forces else set())
    if not meant and not known - LASTING:
        return False
    return all(groups & world.true for groups in meant) and known <= world.effects
