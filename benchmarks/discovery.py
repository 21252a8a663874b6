"""How well hidden effects are found: python -m benchmarks.discovery.

Campaigns of hard spheres with known noise; each effect is hidden at d = 4, 5, 6, where d is its
size over the standard error that these shots give it when nothing is missing. Prints how often
something is claimed when nothing is missing, how often something is found and rightly named, and
the times of fit, rank and explain for 120 shots. Writes out/discovery.json.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from analysis.effects.catalogue import CATALOGUE
from analysis.model.fit import fit_campaign
from analysis.model.poses import PoseData
from analysis.model.ranking import rank
from analysis.model.selection import explain
from tests.unit.analysis.model.hard_spheres import Hidden, campaign

OUT = Path("out/discovery.json")
STRENGTHS = (4, 5, 6)
TIMED_SHOTS = 120


def moved(data: PoseData, shift: np.ndarray) -> PoseData:
    return replace(data, position=data.position + shift)


def fallen(shots: int, seed: int, angle: float) -> PoseData:
    data = campaign(shots, seed)
    tau = (data.times_s - data.times_s.mean())[..., None]
    push = 0.5 * data.gravity * tau**2 * np.array([np.cos(angle) - 1, np.sin(angle), 0])
    return moved(data, push[:, :, None])


def squeezed(shots: int, seed: int, share: float) -> PoseData:
    """Return rows further apart than columns: X in the front view, Z in the top view."""
    data = campaign(shots, seed)
    return replace(data, position=data.position * (1 + share * np.array([1, 0, 1])))


def stretched(shots: int, seed: int, share: float) -> PoseData:
    data = campaign(shots, seed)
    return replace(data, position=data.position * (1 + share))


def sheared(shots: int, seed: int, angle: float) -> PoseData:
    """Return what a camera rolled about its axis shows: the mirror's rows shear with it."""
    data = campaign(shots, seed)
    x, y, z = np.moveaxis(data.position, -1, 0)
    return replace(data, position=np.stack([x - angle * y, y + angle * x, z + angle * y], axis=-1))


def slowed(shots: int, seed: int, share: float) -> PoseData:
    """Return what a clock that runs slow by a share tells."""
    data = campaign(shots, seed)
    return replace(data, times_s=data.times_s / (1 + share))


def viscoelastic(shots: int, seed: int, slope: float) -> PoseData:
    return campaign(shots, seed, hidden=Hidden(slope=slope))


HIDDEN: dict[str, Callable[[int, int, float], PoseData]] = {
    "image-scale": stretched,
    "pixel-aspect": squeezed,
    "camera-roll": sheared,
    "gravity-direction": fallen,
    "frame-rate": slowed,
    "restitution-viscoelastic": viscoelastic,
}


def efficient_sigmas(shots: int) -> dict[str, float]:
    """Return the standard error of each effect's first parameter when nothing is missing."""
    data = campaign(shots, 1)
    ranking = rank(data, fit_campaign(data), [e for e in CATALOGUE if e.name in HIDDEN])
    return {c.effect.name: float(c.sigmas[0]) for c in ranking.candidates}


def false_claims(campaigns: int, shots: int) -> dict[str, float]:
    words = [explain(campaign(shots, 10_000 + k), CATALOGUE).verdict for k in range(campaigns)]
    return {
        word: words.count(word) / campaigns for word in ("none", "effect", "alias", "unexplained")
    }


def found(name: str, size: float, seeds: range, shots: int) -> dict[str, float]:
    """Return the shares of campaigns with a claim, with the right name in it, and by itself."""
    make, claimed, among, alone = HIDDEN[name], 0, 0, 0
    for seed in seeds:
        verdict = explain(make(shots, seed, size), CATALOGUE)
        named = {*verdict.alias_set, *verdict.effects}
        claimed += verdict.verdict != "none"
        among += name in named
        alone += named == {name}
    return {
        "claimed": claimed / len(seeds),
        "right_among": among / len(seeds),
        "right_alone": alone / len(seeds),
    }


def times(shots: int) -> dict[str, float]:
    """Return how long the work of each command takes with one effect hidden, s."""
    data = stretched(shots, 3, 1e-3)
    start = time.perf_counter()
    fit = fit_campaign(data)
    fitted = time.perf_counter()
    rank(data, fit, CATALOGUE)
    ranked = time.perf_counter()
    explain(data, CATALOGUE)
    explained = time.perf_counter()
    return {
        "fit_s": fitted - start,
        "rank_s": ranked - fitted,
        "explain_s": explained - ranked,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=4, help="of each kind")
    parser.add_argument("--shots", type=int, default=40, help="in each campaign")
    wanted = parser.parse_args()
    timing = times(TIMED_SHOTS)
    print(f"{TIMED_SHOTS} shots: " + ", ".join(f"{k[:-2]} {v:.2f} s" for k, v in timing.items()))
    quiet = false_claims(wanted.campaigns, wanted.shots)
    print(f"nothing missing: {1 - quiet['none']:.3f} claims of {wanted.campaigns} campaigns")
    print(f"{'hidden':<26}{'d':>3}{'claimed':>10}{'among':>10}{'alone':>10}")
    next_seed = 20_000
    power: dict[str, dict[str, dict[str, float]]] = {}
    for name, sigma in efficient_sigmas(wanted.shots).items():
        power[name] = {}
        for d in STRENGTHS:
            seeds = range(next_seed, next_seed + wanted.campaigns)
            next_seed = seeds.stop
            shares = found(name, d * sigma, seeds, wanted.shots)
            power[name][str(d)] = shares
            print(f"{name:<26}{d:>3}" + "".join(f"{share:>10.2f}" for share in shares.values()))
    OUT.parent.mkdir(exist_ok=True)
    document = {
        "campaigns": wanted.campaigns,
        "shots": wanted.shots,
        "effects_in_the_catalogue": len(CATALOGUE),
        "times": timing,
        "nothing_missing": quiet,
        "power": power,
    }
    OUT.write_text(json.dumps(document, indent=1, allow_nan=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
