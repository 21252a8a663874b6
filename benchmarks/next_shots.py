"""How well next shots do what they promise: python -m benchmarks.next_shots.

A campaign hides an effect. Next shots are asked for that tell it from a rival with probability .9;
then many campaigns like it are fired, each followed by more and fewer of the proposed shots, and
by as many spread evenly, all with physics of their own (simulators.challenge). Counted is how often
the right effect lowers chi-squared most. Prints, for each pair, the number proposed over the number
really needed, and the number needed over that of an even design. Writes out/next_shots.json.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation
from scipy.special import ndtr, ndtri

from analysis.collision.operator import Body
from analysis.effects.catalogue import CATALOGUE
from analysis.effects.effect import Effect
from analysis.launch.fit import fit_launch
from analysis.launch.prediction import Limits
from analysis.model.design.between import PROBABILITY, Repeated, Telling, best_fit, tell_apart
from analysis.model.design.candidates import grid
from analysis.model.fit import fit_campaign
from analysis.model.poses import PoseData
from analysis.setup import CameraSetup
from simulators.challenge.camera import OPTICS, apparent
from simulators.challenge.encounter import follow
from simulators.challenge.launch import Settings, draw_settings, draw_touch
from simulators.challenge.nature import Nature
from simulators.world.description import Sphere

Floats = NDArray[np.float64]

OUT = Path("out/next_shots.json")
LIMITS = Limits((12.0, 95.0), (0.0, 22.0))
FRAMES, RATE_HZ = 24, 1000.0
CENTRE_PX, TURN_RAD = 0.03, float(np.radians(0.46))
FACTORS = (0.0, 0.5, 1.0, 1.6)
_NEEDED = ("proposed_needed", "even_needed")
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


CASES = (
    Case("restitution-viscoelastic", "restitution-plastic", Nature(viscosity=0.3), 12),
    Case("restitution-plastic", "restitution-viscoelastic", Nature(restitution_power=0.05), 12),
    Case("mass-mismatch", "radius-mismatch", Nature(mass_difference=0.01), 12),
)


def fired(settings: Settings, nature: Nature, seed: int) -> PoseData:
    """Fire and measure shots at given settings, in their order."""
    rng = np.random.default_rng(seed)
    shots = len(settings.offset_mm)
    touch = draw_touch(settings, Sphere(), rng)
    times = np.arange(FRAMES) / RATE_HZ
    contact = (FRAMES // 2 - 1 + rng.uniform(0.02, 0.98, shots)) / RATE_HZ
    since = (times - contact[:, None]) * (1.0 + nature.frame_rate)
    way = follow(nature, settings, touch, since)
    stated = np.broadcast_to(times, since.shape)
    sigma = CENTRE_PX / OPTICS.scale_px_per_m
    position = apparent(way.centres, stated, nature, OPTICS)
    position = position + sigma * rng.normal(size=position.shape)
    turned = np.repeat(Rotation.random(2 * shots, rng=rng).as_matrix(), FRAMES, axis=0)
    rotation = turned.reshape(shots, 2, FRAMES, 3, 3).swapaxes(1, 2)
    for turn in (way.in_contact, way.in_flight, TURN_RAD * rng.normal(size=position.shape)):
        matrix = Rotation.from_rotvec(turn.reshape(-1, 3)).as_matrix()
        rotation = matrix.reshape(rotation.shape) @ rotation
    return PoseData(
        shots=np.arange(1, shots + 1),
        times_s=stated.copy(),
        position=position,
        position_sigma=np.full(position.shape, sigma),
        rotation=rotation,
        rotation_sigma=np.full(position.shape[:3], TURN_RAD),
        bodies=(Body.sphere(0.0254, 1150.0, 0.4),) * 2,
        gravity=9.80665,
        air_density=1.2,
        covariates={
            "order": settings.order,
            "pressure_a_kpa": settings.pressure_kpa,
            "pressure_b_kpa": settings.pressure_kpa,
            "offset_mm": settings.offset_mm,
        },
        camera=CameraSetup(
            RATE_HZ,
            front_view_rows=(88, 192),
            top_view_rows=(0, 88),
            scale_px_per_m=OPTICS.scale_px_per_m,
            front_origin_px=OPTICS.front_origin_px,
            top_origin_px=OPTICS.top_origin_px,
        ),
    )


def proposed(case: Case, seed: int) -> Telling:
    """Fire a campaign and ask for the shots that tell the pair apart."""
    rng = np.random.default_rng([seed, 1])
    data = fired(draw_settings(case.shots, rng), case.nature, seed)
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


def named(case: Case, more: Floats, counts: Sequence[int], seed: int) -> list[bool]:
    """Fire a campaign and more shots; return whether the right effect leads after each count."""
    rng = np.random.default_rng([seed, 2])
    first = draw_settings(case.shots, rng)
    settings = Settings(
        np.concatenate([first.pressure_kpa, more[:, 0]]),
        np.concatenate([first.offset_mm, more[:, 1]]),
        np.full(case.shots + len(more), 23.0),
    )
    data = fired(settings, case.nature, seed)
    found = []
    for count in counts:
        part = data.part(slice(0, case.shots + count))
        base = fit_campaign(part)
        right, wrong = (best_fit(part, base, effect) for effect in case.pair)
        found.append(right.chi2 < wrong.chi2)
    return found


def needed(counts: Sequence[int], named_right: NDArray[np.bool_]) -> float:
    """Return at how many shots the share of the right ones is .9.

    Likeliest curve Phi(sqrt(a + b n) / 2) through the counts (campaigns, counts).
    """
    n, right, tried = np.array(counts), named_right.sum(axis=0), len(named_right)

    def cost(logs: Floats) -> float:
        share = np.clip(ndtr(np.sqrt(np.exp(logs[0]) + np.exp(logs[1]) * n) / 2), 1e-9, 1 - 1e-9)
        return -float((right * np.log(share) + (tried - right) * np.log(1 - share)).sum())

    start = np.log([0.5, 6.0 / max(n.mean(), 1.0)])
    a, b = np.exp(minimize(cost, start, method="Nelder-Mead").x)
    return float(((2 * ndtri(PROBABILITY)) ** 2 - a) / b)


def tried(case: Case, seed: int, campaigns: int) -> dict[str, object]:
    """Propose, then count."""
    told = proposed(case, seed)
    grown = {"proposed": told.count, "even": told.even or 5 * told.count}
    row: dict[str, object] = {"hidden": case.hidden, "rival": case.rival, **grown}
    for name, number in grown.items():
        counts = [round(factor * number) for factor in FACTORS]
        found = []
        for k in range(campaigns):
            rng = np.random.default_rng([seed, k, 3])
            most = counts[-1]
            more = drawn(told.shots, most, rng) if name == "proposed" else even(most, rng)
            found.append(named(case, more, counts, 1000 * (seed + 1) + k))
        table = np.array(found)
        row[f"{name}_named"] = [float(share) for share in table.mean(axis=0)]
        row[f"{name}_needed"] = needed(counts, table)
    return row


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=40, help="fired for each design")
    parser.add_argument("--seeds", type=int, default=1, help="proposals for each pair")
    wanted = parser.parse_args()
    print(f"{'hidden':<26}{'rival':<26}{'proposed':>9}{'needed':>8}{'even':>7}{'p/n':>6}{'n/e':>6}")
    rows = []
    for case in CASES:
        for seed in range(1, wanted.seeds + 1):
            row = tried(case, seed, wanted.campaigns)
            rows.append(row)
            count, want, flat = (float(str(row[k])) for k in ("proposed", *_NEEDED))
            print(
                f"{case.hidden:<26}{case.rival:<26}{count:>9.0f}{want:>8.1f}{flat:>7.1f}"
                f"{count / want:>6.2f}{want / flat:>6.2f}",
                flush=True,
            )
    OUT.parent.mkdir(exist_ok=True)
    document = {"campaigns": wanted.campaigns, "factors": FACTORS, "rows": rows}
    OUT.write_text(json.dumps(document, indent=1, allow_nan=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
