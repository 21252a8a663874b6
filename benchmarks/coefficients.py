"""Coefficients of rendered sweeps beside their truth: python -m benchmarks.coefficients --seeds 8.

Each seed is a campaign of shots over 25 to 85 kPa and 0 to 18 mm, measured as a rig's are. What all
shots of a campaign share is drawn from its stated width: the drag coefficient that is rendered, and
the scale, by which measured places are multiplied. A pull is an error over its stated one; 1 rms is
right.
Printed are own pulls (the error less what the drawn numbers do to it, over the shot's own error)
and total pulls (the whole error over the whole stated one), for single shots and for the report:
its mean e against that of the true velocities with the same weights, and what it fits to all poses
against the world's contact.
"""

from __future__ import annotations

import argparse
import tempfile
from collections import defaultdict
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from analysis.campaign import read_campaign
from analysis.effects.contact.lasting_contact import EFFECT
from analysis.exchange.pose_table import measured_poses
from analysis.model.data.gather import pose_data
from analysis.model.data.poses import PoseData
from analysis.results.campaign import Results, mean_restitution, results
from analysis.results.impacts import Impacts
from analysis.results.ratios import Ratio, ratios, velocities
from analysis.scene import Scene
from analysis.setup import Setup
from analysis.shot import MeasuredShot
from analysis.shot_poses import ShotPoses
from analysis.slow_errors import typical
from analysis.two_sides import measure_two_sides
from benchmarks.tracks.__main__ import FRAMES, STEPS, Measured, measured
from benchmarks.tracks.flights import common_scale
from benchmarks.tracks.pulls import rms
from simulators.world import WorldDescription, write_campaign
from simulators.world.contact import Touch, collide
from simulators.world.description import ContactLaw, Sphere
from simulators.world.state import Motion

Floats = NDArray[np.float64]
Pulls = dict[str, list[float]]

STATED_DRAG, DRAG_SIGMA = 0.42, 0.2
SPEEDS = ("v_n", "v_s", "v_n_after", "v_s_after")
"""In the order of an impact's numbers."""
BRIEF = ("v_n", "v_s", "e", "beta")
SCALE, DRAG = 0, 1
"""Rows of what all shots share."""


def head_on() -> float:
    """Return the e of the rendered world: what its contact, in its steps, leaves of 2 m/s.

    1.5e-5 less than its damping is meant to leave, which is what twelve shots tell.
    """
    ball, upright, still = Sphere(), np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3)
    along = np.array([1.0, 0.0, 0.0])
    a = Motion(still, along, upright, still)
    b = Motion(2 * ball.radius_m * along, -along, upright, still)
    parted = collide(Touch(0.0, (ball, ball), (a, b), (still, still)), ContactLaw()).motions[-1]
    return float((parted[1].velocity - parted[0].velocity)[0] / 2.0)


CONTACT = {
    "e": head_on(),
    "mu": ContactLaw().friction,
    f"{EFFECT.name}.kappa": ContactLaw().tangential_stiffness_ratio,
    f"{EFFECT.name}.zeta": ContactLaw().tangential_damping_ratio,
}
"""Truth of what a report fits."""
STATED = f"drag_coefficient = {STATED_DRAG}\ndrag_coefficient_sigma = {DRAG_SIGMA}\n"


@dataclass(frozen=True, slots=True)
class Drawn:
    """How far what all shots share lies from what is stated, in stated errors."""

    drag: float
    scale: float


def rendered(folder: Path, seed: int, shots: int, drag: float) -> None:
    """Render a campaign in air of a drawn drag, and state what is known of it beforehand."""
    nominal = WorldDescription()
    coefficient = max(0.0, STATED_DRAG + DRAG_SIGMA * drag)
    air = replace(nominal.environment, drag_coefficient=coefficient)
    grid = np.meshgrid(np.linspace(25.0, 85.0, STEPS), np.linspace(0.0, 18.0, STEPS))
    order = np.random.default_rng(seed).permutation(STEPS * STEPS)[:shots]
    pressures, offsets = (axis.ravel()[order].tolist() for axis in grid)
    world = replace(nominal, environment=air)
    write_campaign(
        folder, pressures, offsets, seed, frames=FRAMES, state_scale=False, description=world
    )
    path = folder / "campaign.toml"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("[environment]\n", "[environment]\n" + STATED), encoding="utf-8")


def draws(campaigns: int, seed: int) -> Floats:
    """Return drag and scale of each campaign: quantiles of the normal distribution, shuffled.

    Few campaigns then spread as many would. Shape (2, campaigns).
    """
    quantiles = norm.ppf((np.arange(campaigns) + 0.5) / campaigns)
    rng = np.random.default_rng(seed)
    return np.stack([rng.permutation(quantiles) for _ in range(2)])


def rescaled(shot: MeasuredShot, setup: Setup, factor: float) -> MeasuredShot:
    """Return the shot as another scale would have it: places so many times as large."""
    poses = ShotPoses.of_tracks(shot.centres, shot.orientations, shot.times_s)
    poses = replace(poses, position=factor * poses.position)
    return replace(shot, impact=measure_two_sides(poses, Scene.of(setup, shot.slow)).impact)


def impacts_of(shots: list[tuple[int, MeasuredShot]]) -> Impacts:
    """Return the measured impacts as a report has them; shots without spins are left out."""
    whole = [(n, s.impact) for n, s in shots if s.impact.v_s is not None]
    rows = [[q.value for q in (i.v_n, i.v_s, i.v_n_after, i.v_s_after) if q] for _, i in whole]
    return Impacts(
        np.array([n for n, _ in whole]),
        np.array(rows),
        np.array([i.covariance for _, i in whole]),
        3.5,
        shared=np.array([i.shared for _, i in whole]),
    )


def poses_of(
    found: dict[int, Measured], setup: Setup, factor: float, slow: float = 1.0
) -> PoseData:
    """Return the poses of a campaign as its exchange folder has them, at another scale.

    Parameters
    ----------
    slow
        By what their stated slow errors are multiplied.
    """
    shots = {number: measured_poses(shot) for number, (shot, _) in found.items()}
    data = pose_data(shots, (), typical(setup, [shot.slow for shot, _ in found.values()]))
    stated = data.slow
    lasting = replace(
        stated,
        position_m=slow * stated.position_m,
        rotation_rad=slow * stated.rotation_rad,
    )
    return replace(data, position=factor * data.position, slow=lasting)


def judge_report(report: Results, true: Floats) -> Pulls:
    """Return total pulls of a report; true velocities, m/s, shape (S, 4)."""
    if not report.lasting:
        return {}
    exact = replace(report.impacts, velocities=true)
    mean, right = (mean_restitution(i, report.lines.used) for i in (report.impacts, exact))
    total = {"report, mean e": [(mean.value - right.value) / mean.sigma]}
    for name, truth in CONTACT.items():
        fitted = report.whole_fit[name]
        total[f"report, fitted {name}"] = [(fitted.value - truth) / fitted.sigma]
    return total


def judge(found: dict[int, Measured], report: Results, drawn: Drawn) -> tuple[Pulls, Pulls]:
    """Return own and total pulls of single shots and of the report."""
    own, total = defaultdict[str, list[float]](list), defaultdict[str, list[float]](list)
    impacts = impacts_of([(n, shot) for n, (shot, _) in found.items()])
    shots = [found[int(n)] for n in impacts.shots]
    true = np.array([[truth[name] for name in SPEEDS] for _, truth in shots])
    found_too_long = common_scale(shots, WorldDescription().optics)
    scale = drawn.scale + found_too_long / shots[0][0].slow.scale
    assert impacts.shared is not None
    done = scale * impacts.shared[:, SCALE] + drawn.drag * impacts.shared[:, DRAG]
    exact, freed = (replace(impacts, velocities=v) for v in (true, impacts.velocities - done))
    every = [_named(each) for each in (impacts, freed, exact)]
    for name, measured_, apart, truth in zip(
        every[0], *(each.values() for each in every), strict=True
    ):
        total[name] = _told((measured_.value - truth.value) / measured_.sigma)
        own[name] = _told((apart.value - truth.value) / measured_.own)
    for shot, truth in shots:
        state = shot.impact.before, shot.impact.after
        for k, side in enumerate(("before", "after")):
            for i, spin in enumerate((state[k].spin_a, state[k].spin_b)):
                off = spin - np.array(truth[f"spin_{side}"][i])
                own["spin"] += _told(off / shot.impact.state_sigma[k, 2 + i])
    seen = np.searchsorted(impacts.shots, report.impacts.shots)
    total.update(judge_report(report, true[seen]))
    return own, total


def _named(impacts: Impacts) -> dict[str, Ratio]:
    each = ratios(impacts)
    return {**dict(zip(SPEEDS, velocities(impacts), strict=True)), "e": each.e, "beta": each.beta}


def _told(pulls: Floats) -> list[float]:
    return [float(pull) for pull in pulls if np.isfinite(pull)]


def main() -> None:
    """Render, measure, judge and print."""
    parser = argparse.ArgumentParser(prog="benchmarks.coefficients", description=__doc__)
    parser.add_argument("--seeds", type=int, default=8, help="how many campaigns")
    parser.add_argument("--first", type=int, default=101, help="seed of the first")
    parser.add_argument("--shots", type=int, default=12, help="of each campaign, 36 at most")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--nominal", action="store_true", help="draw nothing")
    parser.add_argument(
        "--slow", type=float, default=1.0, help="times the stated slow errors, for the report"
    )
    chosen = parser.parse_args()
    own, total = defaultdict[str, list[float]](list), defaultdict[str, list[float]](list)
    every_draw = draws(chosen.seeds, chosen.first)
    for seed in range(chosen.first, chosen.first + chosen.seeds):
        place = seed - chosen.first
        drawn = Drawn(0.0, 0.0) if chosen.nominal else Drawn(*map(float, every_draw[:, place]))
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch) / "campaign"
            rendered(folder, seed, chosen.shots, drawn.drag)
            setup = read_campaign(folder).jobs[0].setup
            seen = measured(folder, chosen.workers)
        factor = 1.0 + drawn.scale * next(iter(seen.values()))[0].slow.scale
        shots = {n: (rescaled(shot, setup, factor), truth) for n, (shot, truth) in seen.items()}
        report = results(poses_of(seen, setup, factor, chosen.slow))
        parts = judge(shots, report, drawn)
        for every, part in zip((own, total), parts, strict=True):
            for name, pulls in part.items():
                every[name] += pulls
        brief = ", ".join(f"{name} {rms(np.array(parts[0][name])):.2f}" for name in BRIEF)
        print(
            f"seed {seed}: drag {drawn.drag:+.2f}, scale {drawn.scale:+.2f} stated errors; "
            f"own pulls, rms: {brief}",
            flush=True,
        )
    print(f"{'':16}{'own pulls: of':>14}{'rms':>7}{'worst':>7}{'total: rms':>13}{'worst':>7}")
    for name, pulls in own.items():
        line = f"{name:16}{len(pulls):14d}{rms(np.array(pulls)):7.2f}{np.abs(pulls).max():7.1f}"
        if name in total:
            line += f"{rms(np.array(total[name])):13.2f}{np.abs(total[name]).max():7.1f}"
        print(line)
    for name in (name for name in total if name not in own):
        line = f"{name:28}{len(total[name]):9d}{rms(np.array(total[name])):27.2f}"
        print(f"{line}{np.abs(total[name]).max():7.1f}")


if __name__ == "__main__":
    main()
