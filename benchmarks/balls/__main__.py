"""Drawn films of balls beside their truth: python -m benchmarks.balls --films 6.

For each camera films of other balls, lights, grounds and drops are drawn, measured as `rigctl
analyse` does, and held against the law that they were drawn with: e's error and its pull (error
over stated error; 1 rms is right), what that error consists of, and the same of places: as they
are, and up to a shift and a scale, which flights do not tell. Films of `--keep` are drawn once.
With `--as-believed` plates are level and the coefficient of drag is what `known` takes
as its middle, as in films that others render: errors by those two are then not drawn.
With `--as-wide` the camera's look, the ball's way along it, the floor's lean and the drag are drawn
as wide as `known` takes them to be: pulls of e are then 1 rms where errors are worked out rightly.
With `--worlds` films are what telephones make of real rooms: H.264, exposure set anew, seams, white
on bright, hands, shadows; "nearing" is a ball that comes towards the camera.
"""

from __future__ import annotations

import argparse
import math
import tempfile
import time
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from analysis.balls.analysis import AnalysedFilm, FilmJob, analyse_film
from analysis.balls.films.reading import film_of_shot
from analysis.balls.flight.known import (
    DRAG_COEFFICIENT,
    DRAG_SIGMA,
    DRIFT_SHARE,
    LEVEL_SIGMA,
    LOOK_SIGMA,
    Ball,
)
from analysis.balls.measuring import coefficient
from analysis.errors import ShotRefusedError
from benchmarks.balls.budget import budget
from benchmarks.balls.dropping import GRAVITY
from benchmarks.balls.filming import PLAIN, Scene, Truth, film
from benchmarks.balls.scenes import KINDS, scene
from benchmarks.balls.truths import aligned_off
from benchmarks.balls.worlds import WORLDS, world

NEAR_S = 0.03
SHOWN = 6


@dataclass(slots=True)
class Tally:
    """Errors of e and their pulls; pulls of places in each film, as they are and aligned."""

    errors: list[float] = field(default_factory=list)
    pulls: list[float] = field(default_factory=list)
    places: list[tuple[float, float]] = field(default_factory=list)
    sources: list[dict[str, float]] = field(default_factory=list)

    def add(self, error: float, sigma: float) -> None:
        self.errors.append(error)
        self.pulls.append(error / sigma)

    def told(self) -> str:
        errors, pulls = np.array(self.errors), np.array(self.pulls)
        if len(errors) == 0:
            return "no bounces"
        return (
            f"{len(errors)} bounces, e off by {np.sqrt((errors**2).mean()):.5f} rms, "
            f"{np.abs(errors).max():.5f} at most; pull {np.sqrt((pulls**2).mean()):.2f} rms, "
            f"{np.abs(pulls).max():.1f} at most; places: {self.of_places()}"
        )

    def of_sources(self) -> str:
        """Say what the errors of e consist of: medians over all bounces, the largest first."""
        names = {name for each in self.sources for name in each}
        middle = {n: float(np.median([each[n] for each in self.sources])) for n in names}
        largest = sorted(middle, key=lambda name: -middle[name])[:SHOWN]
        return ", ".join(f"{name} {middle[name]:.5f}" for name in largest)

    def of_places(self) -> str:
        """Say the pulls of places: of all films together, and of the least and the most true."""
        pulls = np.array(self.places)
        said = []
        for name, own in zip(("pull", "aligned"), pulls.T, strict=True):
            together = np.sqrt((own**2).mean())
            said.append(f"{name} {together:.2f} rms, films {own.min():.2f} to {own.max():.2f}")
        return ", ".join(said)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--films", type=int, default=4)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--kinds", nargs="*", choices=KINDS, default=list(KINDS))
    parser.add_argument("--worlds", nargs="*", choices=WORLDS, help="these (none: all) instead")
    parser.add_argument("--as-believed", action="store_true", help="level plates, usual drag")
    parser.add_argument("--as-wide", action="store_true", help="what is believed, as wide as it is")
    parser.add_argument("--keep", type=Path, help="folder for the films")
    asked = parser.parse_args()
    home = asked.keep or Path(tempfile.mkdtemp())
    kinds = asked.kinds if asked.worlds is None else asked.worlds or list(WORLDS)
    for kind in kinds:
        tally = Tally()
        for seed in range(asked.first, asked.first + asked.films):
            drawn, beside = world(kind, seed) if kind in WORLDS else (scene(kind, seed), PLAIN)
            if asked.as_believed:
                drawn = _as_believed(drawn)
            if asked.as_wide:
                drawn = _as_wide(drawn, np.random.default_rng([seed, 1]))
            folder = home / f"{kind.replace(' ', '')}-{seed}"
            truth = film(folder, drawn, seed, beside)
            one(folder, drawn, truth, tally)
        print(f"== {kind}: {tally.told()}", flush=True)
        print(f"   errors of e in the middle: {tally.of_sources()}", flush=True)


def _as_believed(drawn: Scene) -> Scene:
    stage, drop, camera, frames = drawn
    return stage, replace(drop, drag_coefficient=DRAG_COEFFICIENT, lean=0.0), camera, frames


def _as_wide(drawn: Scene, rng: np.random.Generator) -> Scene:
    """Draw what the fit has priors of by those priors, the floor in the same row of the picture."""
    stage, drop, camera, frames = drawn
    look = abs(rng.normal(0.0, LOOK_SIGMA))
    eye = stage.eye.copy()
    eye[1] -= eye[2] * (math.tan(look) - math.tan(stage.look_down))
    speed = drop.speed.copy()
    fallen = math.hypot(speed[1], math.sqrt(2.0 * GRAVITY * drop.start[1]))
    speed[2] = rng.normal(0.0, math.hypot(speed[0], DRIFT_SHARE * fallen))
    drop = replace(
        drop,
        speed=speed,
        drag_coefficient=rng.normal(DRAG_COEFFICIENT, DRAG_SIGMA),
        lean=rng.normal(0.0, LEVEL_SIGMA),
    )
    return replace(stage, eye=eye, look_down=look), drop, camera, frames


def one(folder: Path, drawn: Scene, truth: Truth, tally: Tally) -> None:
    _, drop, camera, _ = drawn
    density = drop.mass / (np.pi / 6 * drop.diameter**3)
    exposure = camera.exposure_s if camera.kind == "12 bits" else None
    ball = Ball(drop.diameter, density=density)
    path = film_of_shot(folder / "frames", 1)
    begun = time.perf_counter()
    try:
        found = analyse_film(FilmJob(1, path, ball, camera.rate_hz, exposure))
    except ShotRefusedError as refusal:
        print(f"{folder.name}: refused: {refusal}")
        return
    seconds = time.perf_counter() - begun
    told = centres(found, truth, tally)
    print(f"{folder.name}: {told}, {seconds:.1f} s; {'; '.join(found.notes)}", flush=True)
    flights = found.measured.flights
    for bounce in range(0 if flights is None else flights.bounces):
        assert flights is not None
        when = float(flights.contacts[bounce, 0])
        nearest = min(truth.bounces, key=lambda each: abs(each.time - when))
        if abs(nearest.time - when) > NEAR_S:
            print(f"   a bounce at {when:.4f} s that is none")
            continue
        value, sigma = coefficient(found.measured, bounce)
        v_n = flights.contacts[bounce, 1] / flights.scale_px_per_m
        tally.add(value - nearest.e, sigma)
        sources = budget(flights, bounce, sigma)
        tally.sources.append(sources)
        largest = ", ".join(f"{name} {part:.5f}" for name, part in list(sources.items())[:SHOWN])
        print(
            f"   e {value:.4f} ± {sigma:.4f}, drawn {nearest.e:.4f}: {tally.errors[-1]:+.4f}, "
            f"pull {tally.pulls[-1]:+.1f}; v_n {100 * (v_n / nearest.v_n - 1):+.2f} %; "
            f"time {1e3 * (when - nearest.time):+.3f} ms; error: {largest}"
        )


def centres(found: AnalysedFilm, truth: Truth, tally: Tally) -> str:
    """Say how far places lie from the drawn ones."""
    placed, flights = found.measured.placed, found.measured.flights
    used = np.ones(len(placed.frames), bool) if flights is None else flights.used
    drawn = truth.seen[placed.frames[used]]
    off = placed.places[used] - drawn[:, :2]
    stated, scatter = placed.sigmas[used], found.measured.scatter[used]
    left = aligned_off(off, drawn, scatter)
    pull, aligned = (float(np.sqrt((each**2).mean())) for each in (off / stated, left / scatter))
    tally.places.append((pull, aligned))
    radius = found.measured.looks.radius_px / float(drawn[:, 2].mean()) - 1
    off_by = np.median(np.abs(left), axis=0)
    apart, whole = np.median(scatter, axis=0), np.median(stated, axis=0)
    return (
        f"{len(drawn)} places, aligned off by {off_by[0]:.3f}, {off_by[1]:.3f} px in the middle "
        f"(scatter {apart[0]:.3f}, {apart[1]:.3f}, pull {aligned:.2f}), all alike by "
        f"{off[:, 0].mean():+.3f}, {off[:, 1].mean():+.3f} px (stated {whole[0]:.3f}, "
        f"{whole[1]:.3f}, pull {pull:.2f}), radius {100 * radius:+.1f} %"
    )


if __name__ == "__main__":
    main()
