"""How well next shots do what they promise: python -m benchmarks.next_shots.

A campaign hides an effect. Next shots are asked for that tell it from a rival with probability .9;
then many campaigns like it are fired, each followed by fewer and more of the proposed shots, and by
shots spread evenly, all with physics of their own (simulators.challenge). Counted is how often the
right effect lowers chi-squared most; how many shots it takes is read off by how much it does.
Prints the number proposed over the number needed (p/n), and the number needed over that of an even
design (n/e). Writes out/next_shots.json.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import ndtri

from analysis.effects.catalogue import CATALOGUE
from analysis.effects.effect import Effect
from analysis.launch.fit import fit_launch
from analysis.launch.prediction import Limits
from analysis.model.design.between import PROBABILITY, Repeated, Telling, best_fit, tell_apart
from analysis.model.design.candidates import grid
from analysis.model.fit import fit_campaign
from simulators.challenge.nature import Nature
from tests.unit.analysis.model.design.at_settings import drawn_settings, fired

Floats = NDArray[np.float64]

OUT = Path("out/next_shots.json")
LIMITS = Limits((12.0, 95.0), (0.0, 22.0))
FACTORS = (0.0, 0.5, 1.0, 1.6)
_AS_PROPOSED = FACTORS.index(1.0)
KNOWN = {effect.name: effect for effect in CATALOGUE}


@dataclass(frozen=True, slots=True)
class Case:
    """An effect, what it is confused with, and the number of shots that leave it open."""

    hidden: str
    rival: str
    nature: Nature
    shots: int

    @property
    def pair(self) -> tuple[Effect, Effect]:
        """Both effects, the hidden one first."""
        return KNOWN[self.hidden], KNOWN[self.rival]


@dataclass(frozen=True, slots=True)
class Row:
    """What came of one case.

    `named` and `even_named` are the shares of campaigns in which the right effect led, after
    `FACTORS` times the number proposed, or foretold for an even design.
    """

    hidden: str
    rival: str
    proposed: int
    needed: float
    named: list[float]
    even_foretold: int | None
    even_needed: float
    even_named: list[float]


CASES = (
    Case("restitution-viscoelastic", "restitution-plastic", Nature(viscosity=0.3), 12),
    Case("restitution-plastic", "restitution-viscoelastic", Nature(restitution_power=0.02), 12),
    Case("mass-mismatch", "radius-mismatch", Nature(mass_difference=0.003), 12),
    Case("image-scale", "radius-mismatch", Nature(image_scale=0.0015), 12),
)


def proposed(case: Case, seed: int) -> Telling:
    """Fire a campaign and ask for the shots that tell the pair apart."""
    data = fired(drawn_settings(case.shots, seed), case.nature, seed)
    base = fit_campaign(data)
    launch = fit_launch(data, base)
    return tell_apart(data, base, launch, case.pair, grid(LIMITS, alike=True))


def drawn(shots: Sequence[Repeated], count: int, rng: np.random.Generator) -> Floats:
    """Return settings (count, 2), kPa and mm, of as many shots of a design, in a drawn order.

    Each setting comes as often as its share says, to within one.
    """
    listed = [
        (one.setting.pressure_a_kpa, one.setting.offset_mm)
        for one in shots
        for _ in range(one.repeat)
    ]
    rounds = [rng.permutation(np.array(listed)) for _ in range(-(-count // len(listed)))]
    return np.concatenate(rounds)[:count]


def even(count: int, rng: np.random.Generator) -> Floats:
    """Return settings spread evenly over the grid."""
    every = [Repeated(setting, 1) for setting in grid(LIMITS, alike=True)]
    return drawn(every, count, rng)


def ahead_after(case: Case, more: Floats, counts: Sequence[int], seed: int) -> list[float]:
    """Fire a campaign and more shots; return by how much the right effect leads after each count.

    In chi-squared, ln(shots) added for each parameter: below zero the wrong one is named.
    """
    data = fired(drawn_settings(case.shots, seed, more), case.nature, seed)
    found = []
    for count in counts:
        part = data.part(slice(0, case.shots + count))
        base = fit_campaign(part)
        right, wrong = (best_fit(part, base, effect) for effect in case.pair)
        extra = len(wrong.theory.names) - len(right.theory.names)
        found.append(wrong.chi2 - right.chi2 + extra * float(np.log(len(part.shots))))
    return found


def needed(counts: Sequence[int], ahead: Floats) -> float:
    """Return at how many shots the right effect leads in nine campaigns of ten.

    Likeliest line m = a + b n through the leads (campaigns, counts), each a Gaussian of mean m and
    variance 4 m, as the difference of two chi-squareds is.
    """
    n = np.array(counts)

    def cost(logs: Floats) -> float:
        m = np.exp(logs[0]) + np.exp(logs[1]) * n
        return float(((ahead - m) ** 2 / (4 * m) + np.log(m)).sum())

    start = np.log([0.5, 6.0 / max(n.mean(), 1.0)])
    a, b = np.exp(minimize(cost, start, method="Nelder-Mead").x)
    return max(0.0, float(((2 * ndtri(PROBABILITY)) ** 2 - a) / b))


def tried(case: Case, seed: int, campaigns: int) -> Row:
    """Propose, then count."""
    told = proposed(case, seed)
    first, flat = (
        fired_after(case, told, seed, campaigns=campaigns, spread=spread)
        for spread in (False, True)
    )
    return Row(case.hidden, case.rival, told.count, *first, told.even, *flat)


def fired_after(
    case: Case, told: Telling, seed: int, *, campaigns: int, spread: bool
) -> tuple[float, list[float]]:
    """Return how many shots are needed, and the share named right after each of `FACTORS`."""
    number = (told.even or 5 * told.count) if spread else told.count
    counts = [round(factor * number) for factor in FACTORS]
    leads = []
    for k in range(campaigns):
        rng = np.random.default_rng([seed, k, 3])
        more = even(counts[-1], rng) if spread else drawn(told.shots, counts[-1], rng)
        leads.append(ahead_after(case, more, counts, 1000 * (seed + 1) + k))
    ahead = np.array(leads)
    return needed(counts, ahead), [float(share) for share in (ahead > 0).mean(axis=0)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=40, help="fired for each design")
    parser.add_argument("--seeds", type=int, default=1, help="proposals for each pair")
    wanted = parser.parse_args()
    headings = ("proposed", "named", "needed", "even", "p/n", "n/e")
    print(f"{'hidden':<26}{'rival':<26}" + "".join(f"{word:>9}" for word in headings))
    rows = []
    for case in CASES:
        for seed in range(1, wanted.seeds + 1):
            row = tried(case, seed, wanted.campaigns)
            rows.append(row)
            numbers = (row.proposed, row.named[_AS_PROPOSED], row.needed, row.even_needed)
            ratios = (
                row.proposed / max(row.needed, 1.0),
                row.needed / max(row.even_needed, 1.0),
            )
            line = "".join(f"{number:>9.2f}" for number in (*numbers, *ratios))
            print(f"{case.hidden:<26}{case.rival:<26}{line}", flush=True)
    OUT.parent.mkdir(exist_ok=True)
    document = {
        "campaigns": wanted.campaigns,
        "factors": FACTORS,
        "rows": [asdict(row) for row in rows],
    }
    OUT.write_text(json.dumps(document, indent=1, allow_nan=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
