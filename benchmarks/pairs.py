"""Two spheres that are hard to follow, beside their truth: python -m benchmarks.pairs --shots 20.

Each kind is a campaign of drawn shots, measured as a user does (`rigctl analyse FOLDER --json`):

- steps: beads of 1 to 3 mm at 250 frames/s, ten frames a side, which move by so many of their radii
  from frame to frame, plain and marked;
- ratio: spheres whose diameters are unlike by a factor, of one material;
- one view: no mirror, or a mirror in the picture that the set-up does not state.

Printed are the shots that were measured, the errors of e, v_n, v_n', v_s and v_s' (rms), their
pulls, errors over stated ones (rms; 1 is right), and the largest pull of all; below, why shots were
refused. The rest of the world is the nylon rig's. The drag coefficient of each campaign is stated
with an error that is drawn, of 0.05 about the true 0.40: many campaigns of few shots show pulls.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from simulators.world import WorldDescription, write_campaign
from simulators.world.description import Sphere, Tube
from simulators.world.optics import Optics
from simulators.world.scene import NO_MIRROR_PX

DRAG, DRAG_SIGMA = 0.40, 0.05
NUMBERS = ("e", "v_n", "v_n_after", "v_s", "v_s_after")
KPA = 40.0
SIDE_FRAMES, BEAD_RATE_HZ, BEAD_PX = 10, 250.0, 20.0
GRAVITY = 9.80665


@dataclass(frozen=True, slots=True)
class Kind:
    """A world by the number of the shot's campaign, and how it is filmed.

    Attributes
    ----------
    world
        Of a campaign, by a number from 0 to 1 that is drawn for it.
    rate_hz, frames
        Of a film.
    offset
        Largest offset of the tubes, in mean diameters.
    kpa
        Range of the pressures.
    mirror
        Whether the set-up states the mirror's view.
    """

    world: Callable[[float], WorldDescription]
    rate_hz: float = 1000.0
    frames: int = 24
    offset: float = 0.7
    kpa: tuple[float, float] = (30.0, 80.0)
    mirror: bool = True


def beads(radii_a_frame: float, *, marked: bool) -> Callable[[float], WorldDescription]:
    """Return the world of beads that move by so many radii from frame to frame."""

    def world(drawn: float) -> WorldDescription:
        diameter = 1e-3 * (1.0 + 2.0 * drawn)
        ball = Sphere(diameter_m=diameter, markers=12 if marked else 0, marker_radius_rad=0.25)
        speed = radii_a_frame * ball.radius_m * BEAD_RATE_HZ
        side_s = (SIDE_FRAMES + 0.5) / BEAD_RATE_HZ
        scale = BEAD_PX / diameter
        fallen = 0.5 * GRAVITY * side_s**2
        tube = Tube(
            mouth_m=speed * side_s,
            height_m=-fallen,
            piston_area_m2=0.5 * ball.mass_kg * speed**2 / (1e3 * KPA * 0.3 * diameter),
            stroke_m=0.3 * diameter,
            friction_n=0.0,
            position_scatter_m=0.01 * diameter,
            valve_jitter_s=1e-5,
        )
        above = round(scale * (fallen + 1.5 * diameter))
        front = above + round(scale * (3.0 * fallen + 6.0 * diameter))
        top = round(5.0 * BEAD_PX)
        columns = 2 * round(scale * (tube.mouth_m + 0.5 * diameter))
        optics = Optics(
            rows=top + front,
            columns=columns,
            scale_px_per_m=scale,
            front_origin_px=(float(top + above), columns / 2),
            top_origin_px=(top / 2, columns / 2),
            front_rows=(top, top + front),
            top_rows=(0, top),
            background_per_column=0.045 * 240 / columns,
        )
        return WorldDescription(sphere_a=ball, sphere_b=ball, tube=tube, optics=optics)

    return world


def unlike(ratio: float, *, marked: bool) -> Callable[[float], WorldDescription]:
    """Return the world of an inch sphere and a smaller one, b or a."""

    def world(drawn: float) -> WorldDescription:
        large = Sphere(markers=16 if marked else 0)
        small = replace(large, diameter_m=large.diameter_m / ratio, marker_radius_rad=0.22)
        a, b = (large, small) if drawn < 0.5 else (small, large)
        return WorldDescription(sphere_a=a, sphere_b=b)

    return world


def nylon(optics: Optics | None = None) -> Callable[[float], WorldDescription]:
    """Return the world of two marked spheres of an inch."""
    return lambda _: WorldDescription(optics=optics or Optics())


ALONE = replace(
    Optics(), front_rows=(0, 192), front_origin_px=(95.5, 120.0), top_origin_px=NO_MIRROR_PX
)
KINDS = {
    "alike, mirror": Kind(nylon()),
    **{
        f"steps of {radii:g} radii, {looks}": Kind(
            beads(radii, marked=looks == "marked"),
            rate_hz=BEAD_RATE_HZ,
            frames=2 * SIDE_FRAMES,
            kpa=(KPA, KPA),
        )
        for radii in (2.0, 4.0, 8.0)
        for looks in ("plain", "marked")
    },
    **{
        f"ratio {ratio:g}, {looks}": Kind(unlike(ratio, marked=looks == "marked"))
        for ratio in (1.5, 2.0, 3.0)
        for looks in ("plain", "marked")
    },
    "one view": Kind(nylon(ALONE), mirror=False),
    "one view, mirror shown": Kind(nylon(), mirror=False),
}


def drawn_campaign(folder: Path, kind: Kind, shots: int, seed: int) -> None:
    """Draw the shots of a campaign, and state what is known of it beforehand."""
    rng = np.random.default_rng(seed)
    world = kind.world(float(rng.uniform()))
    mean_mm = 500.0 * (world.sphere_a.diameter_m + world.sphere_b.diameter_m)
    pressures = rng.uniform(*kind.kpa, shots)
    # The lighter sphere is pushed less, and they meet in the middle at like speeds.
    heavy = max(world.sphere_a.mass_kg, world.sphere_b.mass_kg)
    least = world.tube.friction_n / world.tube.piston_area_m2 / 1e3
    a, b = (
        (least + (pressures - least) * sphere.mass_kg / heavy).tolist()
        for sphere in (world.sphere_a, world.sphere_b)
    )
    write_campaign(
        folder,
        a,
        (mean_mm * rng.uniform(0.0, kind.offset, shots)).tolist(),
        seed,
        pressures_b_kpa=b,
        description=world,
        frame_rate_hz=kind.rate_hz,
        frames=kind.frames,
    )
    path = folder / "campaign.toml"
    stated = f"drag_coefficient = {rng.normal(DRAG, DRAG_SIGMA)}"
    air = f"[environment]\n{stated}\ndrag_coefficient_sigma = {DRAG_SIGMA}\n"
    lines = path.read_text(encoding="utf-8").replace("[environment]\n", air)
    kept = [line for line in lines.splitlines() if kind.mirror or not line.startswith("top_")]
    path.write_text("\n".join(kept) + "\n", encoding="utf-8")


def measured(folder: Path) -> list[tuple[dict[str, Any], dict[str, Any]]]:
    """Return the document of each shot and its truth."""
    command = [str(Path(sys.executable).with_name("rigctl")), "analyse", str(folder), "--json"]
    done = subprocess.run([*command, "--workers", "1"], capture_output=True, text=True, check=False)
    if not done.stdout:
        raise SystemExit(done.stderr)
    truths = {one["shot"]: one for one in json.loads((folder / "truth.json").read_text())["shots"]}
    shots = json.loads(done.stdout)["shots"]
    return [(shot, truths[shot["shot"]]) for shot in shots if "v_n" in truths[shot["shot"]]]


def off(name: str, shot: dict[str, Any], truth: dict[str, Any]) -> tuple[float, float] | None:
    """Return error and stated error of a number of a measured shot; None where it is open."""
    if shot[name] is None:
        return None
    true = -truth["v_n_after"] / truth["v_n"] if name == "e" else truth[name]
    return shot[name]["value"] - true, shot[name]["sigma"]


def rms(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if values else float("nan")


def line(name: str, shots: list[tuple[dict[str, Any], dict[str, Any]]]) -> str:
    """Return the line of a kind."""
    whole = [pair for pair in shots if pair[0]["status"] == "measured"]
    cells, largest = [], 0.0
    for number in NUMBERS:
        errors = [each for pair in whole if (each := off(number, *pair)) is not None]
        pulls = [error / sigma for error, sigma in errors]
        largest = max([largest, *map(abs, pulls)])
        cells.append(f"{rms([error for error, _ in errors]):8.4f} {rms(pulls):5.2f}")
    return f"{name:26}{len(whole):3d}/{len(shots)}" + "".join(cells) + f"{largest:7.1f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--kinds", nargs="+", default=list(KINDS), help="their names begin so")
    parser.add_argument("--campaigns", type=int, default=2, help="of each kind")
    parser.add_argument("--shots", type=int, default=10, help="of each campaign")
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--keep", type=Path, help="keep the frames here, and use those there")
    parser.add_argument("--every-shot", action="store_true", help="print each shot's pulls")
    asked = parser.parse_args()
    print(f"{'':26}measured" + "".join(f"{name:>10} pull" for name in NUMBERS) + " largest")
    with tempfile.TemporaryDirectory() as scratch:
        for name in (each for each in KINDS if each.startswith(tuple(asked.kinds))):
            shots = []
            for seed in range(asked.seed, asked.seed + asked.campaigns):
                folder = (asked.keep or Path(scratch)) / f"{name.replace(' ', '-')}-{seed}"
                if not (folder / "truth.json").exists():
                    drawn_campaign(folder, KINDS[name], asked.shots, seed)
                shots += measured(folder)
            print(line(name, shots), flush=True)
            if asked.every_shot:
                for shot, truth in shots:
                    if shot["status"] == "measured":
                        pulls = {n: off(n, shot, truth) for n in NUMBERS}
                        told = [f"{n} {p[0] / p[1]:+.1f}" for n, p in pulls.items() if p]
                        print(f"    shot {shot['shot']}: {', '.join(told)}")
            why = Counter(f"{s['step']}: {s['reason']}" for s, _ in shots if "reason" in s)
            for reason, count in why.most_common():
                print(f"    {count} refused at {reason[:150]}")


if __name__ == "__main__":
    main()
