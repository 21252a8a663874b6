"""How well next shots do what they promise: python -m benchmarks.next_shots.

Campaigns hide an effect, with physics of their own (simulators.challenge). Each that leaves open
which of a pair it is gets its own next shots, which are then fired, and in another future as many
evenly spread shots as are said to do the same. Counted is how often the right effect leads, beside
what was promised for the case that it is true, and by how much chi-squared comes to prefer it. This
gain goes with the number of shots: p/n, the gain that came over the one that was promised, is the
number proposed over the number needed. n/e compares the shots that chi-squared needs with those of
an even design. Both truths of each pair are tried. Writes out/next_shots.json.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.collision.operator import Body
from analysis.effects.catalogue import CATALOGUE
from analysis.effects.effect import Effect
from analysis.launch.fit import fit_launch
from analysis.launch.prediction import Limits
from analysis.model.data.poses import PoseData
from analysis.model.design.between import Repeated, best_fit, tell_apart
from analysis.model.design.candidates import AFTER_THE_CAMPAIGN, grid
from analysis.model.fitting.adding import ALIAS_WITHIN
from analysis.model.fitting.fit import Fit, fit_campaign
from simulators.challenge.nature import Nature
from tests.unit.analysis.model.design.at_settings import drawn_settings, fired

Floats = NDArray[np.float64]

OUT = Path("out/next_shots.json")
LIMITS = Limits((12.0, 95.0), (0.0, 22.0))
SHOTS = 12
DIAMETER_M, DENSITY, SOLID = 0.0254, 1150.0, 0.4
KNOWN = {effect.name: effect for effect in CATALOGUE}


@dataclass(frozen=True, slots=True)
class World:
    """What shots obey, and by which shares the spheres are larger than the campaign states."""

    nature: Nature = field(default_factory=Nature)
    larger: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Case:
    """A hidden effect, what it is confused with, and the worlds that hide it."""

    hidden: str
    rival: str
    world: Callable[[np.random.Generator], World]

    @property
    def pair(self) -> tuple[Effect, Effect]:
        """Both effects, the hidden one first."""
        return KNOWN[self.hidden], KNOWN[self.rival]

    @property
    def extra(self) -> int:
        """Parameters that the rival has more."""
        first, second = self.pair
        return len(second.parameters) - len(first.parameters)

    def price(self, more: int) -> float:
        """Return what of a lead is for ln(shots) after more of them."""
        return self.extra * float(np.log1p(more / SHOTS))


@dataclass(frozen=True, slots=True)
class Trial:
    """A campaign that leaves its pair open, and what came of its next shots.

    Attributes
    ----------
    proposed, even
        Shots that were asked for, and evenly spread ones that are said to do as much.
    promised, either
        Probability that the right one is named: where it is the hidden one, as it is, and for not
        knowing.
    foretold, grown
        By how much chi-squared comes to prefer the right one with the proposed shots, ln(shots)
        counted for each parameter.
    even_grown
        The same with the even shots.
    price
        What of this is for ln(shots), with the proposed and with the even shots.
    right
        Whether it then leads.
    """

    proposed: int
    even: int
    promised: float
    either: float
    foretold: float
    grown: float
    even_grown: float
    price: tuple[float, float]
    right: bool


@dataclass(frozen=True, slots=True)
class Row:
    """What came of a case: of its campaigns that left the pair open.

    Attributes
    ----------
    proposed
        Median number of shots.
    promised, either, named
        Means of the probabilities of `Trial`, and the share in which the right one led.
    ratio, ratio_sigma
        Shots proposed over shots needed, by how fast the lead grew, and its standard error.
    of_even, foretold_of_even
        Shots that chi-squared needs over those of an even design: counted, and as was said.
    """

    hidden: str
    rival: str
    open: int
    proposed: float
    promised: float
    named: float
    either: float
    ratio: float
    ratio_sigma: float
    of_even: float
    foretold_of_even: float

    @property
    def line(self) -> str:
        """As a row of the table."""
        numbers = (self.open, self.proposed, self.promised, self.named, self.ratio)
        more = (self.ratio_sigma, self.of_even, self.foretold_of_even)
        return f"{self.hidden:<26}{self.rival:<26}" + "".join(
            f"{number:>9.2f}" for number in (*numbers, *more)
        )


def _always(nature: Nature, rng: np.random.Generator) -> World:
    del rng
    return World(nature)


def _radii(
    middle: tuple[float, float], spread: tuple[float, float], rng: np.random.Generator
) -> World:
    """Return spheres that look like the rival but for as much as one shot alone would show."""
    off = rng.standard_normal()
    return World(larger=(middle[0] + spread[0] * off, middle[1] + spread[1] * off))


VISCOELASTIC, PLASTIC = "restitution-viscoelastic", "restitution-plastic"
LIKE_MASSES = partial(_radii, (0.001, -0.001), (3.5e-4, 3.5e-4))
LIKE_A_SCALE = partial(_radii, (0.0015, 0.0015), (1e-4, -1e-4))
CASES = (
    Case(VISCOELASTIC, PLASTIC, partial(_always, Nature(viscosity=0.3))),
    Case(PLASTIC, VISCOELASTIC, partial(_always, Nature(restitution_power=0.02))),
    Case("mass-mismatch", "radius-mismatch", partial(_always, Nature(mass_difference=0.003))),
    Case("radius-mismatch", "mass-mismatch", LIKE_MASSES),
    Case("image-scale", "radius-mismatch", partial(_always, Nature(image_scale=0.0015))),
    Case("radius-mismatch", "image-scale", LIKE_A_SCALE),
)
"""Both truths of a pair stand together."""


def tried(place: int, seed: int) -> Trial | None:
    """Fire a campaign of a case; if it leaves the pair open, ask for next shots and fire them."""
    case, rng = CASES[place], np.random.default_rng([seed, place])
    world = case.world(rng)
    data = _seen_in(world, fired(drawn_settings(SHOTS, seed), world.nature, seed))
    base = fit_campaign(data)
    before = ahead(case, data, base)
    if abs(before) > ALIAS_WITHIN:
        return None
    told = tell_apart(data, base, fit_launch(data, base), case.pair, grid(LIMITS, alike=True))
    if told.each is None or told.gain is None:
        raise TypeError("two effects were asked for, and the answer is of one")
    even = told.even or 5 * told.count
    every = tuple(Repeated(setting, 1) for setting in grid(LIMITS, alike=True))
    grown, even_grown = (
        ahead(case, _followed(data, world, drawn(design, count, rng), seed + future)) - before
        for future, design, count in ((10_000, told.shots, told.count), (20_000, every, even))
    )
    return Trial(
        proposed=told.count,
        even=even,
        promised=told.each[0],
        either=told.probability,
        foretold=told.gain[0],
        grown=grown,
        even_grown=even_grown,
        price=(case.price(told.count), case.price(even)),
        right=before + grown > 0,
    )


def ahead(case: Case, data: PoseData, base: Fit | None = None) -> float:
    """Return by how much chi-squared prefers the hidden effect, ln(shots) for each parameter in."""
    fit = fit_campaign(data) if base is None else base
    right, wrong = (best_fit(data, fit, effect) for effect in case.pair)
    return wrong.chi2 - right.chi2 + case.extra * float(np.log(len(data.shots)))


def drawn(shots: Sequence[Repeated], count: int, rng: np.random.Generator) -> Floats:
    """Return settings (count, 2), kPa and mm, of as many shots of a design, in a drawn order.

    Each setting comes as often as its share says, to within one.
    """
    listed = [
        (one.setting.pressure_a_kpa, one.setting.offset_mm)
        for one in shots
        for _ in range(one.repeat)
    ]
    if not listed:
        return np.zeros((0, 2))
    rounds = [rng.permutation(np.array(listed)) for _ in range(-(-count // len(listed)))]
    return np.concatenate(rounds)[:count]


def _followed(data: PoseData, world: World, more: Floats, seed: int) -> PoseData:
    """Return a campaign with more shots at the settings (M, 2), fired in the same world."""
    if len(more) == 0:
        return data
    later = _seen_in(world, fired(drawn_settings(0, seed, more), world.nature, seed))
    order = np.full(len(more), AFTER_THE_CAMPAIGN)
    later = replace(later, covariates={**later.covariates, "order": order})
    return PoseData.joined([data, later])


def _seen_in(world: World, data: PoseData) -> PoseData:
    """State the spheres of shots as the campaign's owner has them."""
    a, b = (Body.sphere(DIAMETER_M / (1.0 + d), DENSITY, SOLID) for d in world.larger)
    return replace(data, bodies=(a, b))


def summary(case: Case, trials: Sequence[Trial]) -> Row:
    """Add up what came of the campaigns that left their pair open."""
    foretold, grown, even_grown, price = (
        np.array([getattr(trial, name) for trial in trials])
        for name in ("foretold", "grown", "even_grown", "price")
    )
    proposed, even = (np.array([getattr(t, name) for t in trials]) for name in ("proposed", "even"))
    rates = [
        float((leads - paid).sum() / max(shots.sum(), 1))
        for leads, paid, shots in ((grown, price[:, 0], proposed), (even_grown, price[:, 1], even))
    ]
    return Row(
        hidden=case.hidden,
        rival=case.rival,
        open=len(trials),
        proposed=float(np.median(proposed)),
        promised=float(np.mean([trial.promised for trial in trials])),
        named=float(np.mean([trial.right for trial in trials])),
        either=float(np.mean([trial.either for trial in trials])),
        ratio=float(grown.sum() / foretold.sum()),
        ratio_sigma=float(np.std(grown - foretold) * np.sqrt(len(trials)) / abs(foretold.sum())),
        of_even=float(rates[1] / rates[0]),
        foretold_of_even=float(np.median(proposed / even)),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=40, help="fired of each case")
    parser.add_argument("--cases", type=int, nargs="*", default=range(len(CASES)))
    parser.add_argument("--processes", type=int, default=1)
    wanted = parser.parse_args()
    # Read when a process loads its linear algebra, so set before the first is started.
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ[name] = "1"
    headings = ("open", "proposed", "promised", "named", "p/n", "+-", "n/e", "foretold")
    print(f"{'hidden':<26}{'rival':<26}" + "".join(f"{word:>9}" for word in headings))
    rows = []
    fresh = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(wanted.processes, mp_context=fresh) as pool:
        for place in wanted.cases:
            seeds = range(1, wanted.campaigns + 1)
            found = list(pool.map(partial(tried, place), seeds))
            row = summary(CASES[place], [trial for trial in found if trial is not None])
            rows.append(row)
            print(row.line, flush=True)
    OUT.parent.mkdir(exist_ok=True)
    document = {"campaigns": wanted.campaigns, "rows": [asdict(row) for row in rows]}
    OUT.write_text(json.dumps(document, indent=1, allow_nan=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
