"""Tables of places as trackers write them, beside their truth: python -m benchmarks.balls.tables.

The flights are those of the drawn films, seen by the same cameras; places scatter by a part of a
pixel, as a person's clicks or a tracker's windows do.
"""

from __future__ import annotations

import argparse
import csv
import io
import math
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from analysis.balls.analysis import FilmJob
from analysis.balls.document import Json
from analysis.balls.flight.known import Ball
from analysis.balls.tracks.analysis import analyse_table
from analysis.errors import ShotRefusedError
from benchmarks.balls.dropping import STEP_S, Bounce, Drop, fly
from benchmarks.balls.filming import Scene
from benchmarks.balls.scenes import KINDS, scene

Floats = NDArray[np.float64]
HEARD_S = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """What a tracker saw: frames of a rate, and column and row of each, px; shape (N, 2).

    `px_per_m` is the scale in the plane of the flight that a person would measure.
    """

    rate_hz: float
    frames: NDArray[np.intp]
    places: Floats
    height: int
    px_per_m: float


def tracked(drawn: Scene, seed: int) -> tuple[Seen, list[Bounce]]:
    """Return places of a drawn flight with scatter, and its bounces."""
    stage, drop, camera, count = drawn
    rng = np.random.default_rng(seed)
    _, path, bounces = fly(drop, count / camera.rate_hz + 0.1)
    sigma = rng.uniform(0.1, 0.6)
    row_s = camera.readout_s / stage.size[0]
    places = []
    for frame in range(count):
        place = stage.seen(path[0])
        for _ in range(6):
            time = frame / camera.rate_hz + row_s * place[0]
            place = stage.seen(path[min(len(path) - 1, round(time / STEP_S))])
        places.append(place[::-1] + rng.normal(0.0, sigma, 2))
    ahead = float(-stage.eye[2])
    return (
        Seen(
            camera.rate_hz,
            np.arange(count),
            np.array(places),
            stage.size[0],
            stage.focal_px / ahead * rng.normal(1.0, 0.01),
        ),
        bounces,
    )


def of_tracker(seen: Seen) -> str:
    """Write a table as Tracker does: seconds and metres upwards, with a decimal comma."""
    x, y = (seen.places[:, k] / seen.px_per_m for k in (0, 1))
    rows = zip(seen.frames / seen.rate_hz, x - x[0], y.max() - y, strict=True)
    text = "mass A\t\t\nt (s)\tx (m)\ty (m)\n"
    return text + "".join("\t".join(f"{v:.6E}".replace(".", ",") for v in r) + "\n" for r in rows)


def of_imagej(seen: Seen) -> str:
    """Write a table as ImageJ's MTrack2 does: frames and pixels, and lengths below them."""
    out: list[list[object]] = [["Frame", "X1", "Y1", "Flag1"], ["Tracks", 1, "to", 1]]
    out += [[f + 1, x, y, ""] for f, (x, y) in zip(seen.frames.tolist(), seen.places, strict=True)]
    return _text([*out, ["Track", "Length", "Distance", ""], [1, 1002.3, 575.5, ""]])


def of_trackmate(seen: Seen) -> str:
    """Write a table as TrackMate does: three lines of names and one of units, a spot each row."""
    names = ["LABEL", "TRACK_ID", "QUALITY", "POSITION_X", "POSITION_Y", "POSITION_T", "FRAME"]
    units = ["", "", "(quality)", "(pixel)", "(pixel)", "(sec)", ""]
    out: list[list[object]] = [
        [*names],
        [n.title() for n in names],
        [n.lower() for n in names],
        [*units],
    ]
    for f, (x, y) in zip(seen.frames.tolist(), seen.places, strict=True):
        out.append([f"ID{f}", 0, 8.1, x, y, f / seen.rate_hz, f])
    return _text(out)


def of_trackpy(seen: Seen, bounces: Sequence[Bounce]) -> str:
    """Write a table as trackpy does: a new particle after each bounce, and one that stays."""
    out: list[list[object]] = [["", "y", "x", "mass", "frame", "particle"]]
    for f, (x, y) in zip(seen.frames.tolist(), seen.places, strict=True):
        particle = 3 + sum(bounce.time < f / seen.rate_hz for bounce in bounces)
        out.append([len(out), y, x, 800.0, float(f), float(particle)])
        out.append([len(out), 20.0 + 0.1 * (f % 3), 4.0, 300.0, float(f), 1.0])
    return _text(out)


def of_dltdv(seen: Seen) -> str:
    """Write a table as DLTdv does: a row each frame, upwards, NaN where nothing was digitised."""
    out: list[list[object]] = [["pt1_cam1_X", "pt1_cam1_Y"]]
    up = seen.height - seen.places[:, 1]
    out += [
        [x, y] if n % 9 else ["NaN", "NaN"]
        for n, (x, y) in enumerate(zip(seen.places[:, 0], up, strict=True))
    ]
    return _text(out)


def _text(rows: Sequence[Sequence[object]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def heard(drop: Drop, seed: int) -> tuple[str, list[Bounce]]:
    """Write the times of a flight's bounces as phyphox does, and return the bounces."""
    rng = np.random.default_rng(seed)
    _, _, bounces = fly(drop, 3.0)
    known = bounces[:6]
    names = [f"Bounce {k} (s)" for k in range(len(known))]
    return _text([names, [one.time + rng.normal(0.0, HEARD_S) for one in known]]), known[1:-1]


def impacts_of(text: str, name: str, stated: tuple[Ball, float | None]) -> list[Json]:
    """Return the bounces that are measured in one table; none where it is refused."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_text(text, encoding="utf-8")
        try:
            return list(analyse_table(FilmJob(1, path, *stated)).document["impacts"])
        except ShotRefusedError as refusal:
            print(f"   refused: {refusal.reason}")
            return []


def pulls(
    found: Sequence[Json], truth: Sequence[Bounce], of: Literal["e", "v_n"] = "e"
) -> list[float]:
    """Return the pulls of e, or of the speeds before, of measured bounces."""
    off = []
    for each in found:
        true = min(truth, key=lambda bounce: abs(bounce.time - each["contact_time_s"]))
        off.append((abs(each[of]["value"]) - getattr(true, of)) / each[of]["sigma"])
    return off


def thrown_at_a_wall(drawn: Scene, seed: int) -> Scene:
    """Return a scene whose ball is thrown across the picture at a wall near its right side."""
    stage, drop, camera, frames = drawn
    rng = np.random.default_rng([9, seed])
    ahead = float(-stage.eye[2])
    width, height = (side / stage.focal_px * ahead for side in (stage.size[1], stage.size[0]))
    speed = rng.uniform(1.5, 3.0)
    start = np.array([-0.35 * width, rng.uniform(0.4, 0.55) * height, 0.0])
    velocity = np.array([speed, rng.uniform(0.0, 0.3) * speed, rng.uniform(-0.05, 0.05) * speed])
    wall = 0.4 * width + 0.5 * drop.diameter, rng.uniform(0.5, 0.9)
    return stage, replace(drop, start=start, speed=velocity, wall=wall), camera, frames


def on_a_leaning_plate(drawn: Scene, seed: int) -> tuple[Scene, float]:
    """Return a scene with a plate that leans, and by how much the camera is upright, rad.

    The law has gravity lean over a level plate: places are turned back to an upright camera, which
    a shutter that rolls could not see so.
    """
    stage, drop, camera, frames = drawn
    rng = np.random.default_rng([10, seed])
    lean = math.radians(rng.uniform(2.0, 25.0) * rng.choice([-1.0, 1.0]))
    width = stage.size[1] / stage.focal_px * float(-stage.eye[2])
    start = drop.start - [0.3 * width * np.sign(lean), 0.0, 0.0]
    leaning = replace(drop, start=start, speed=0.3 * drop.speed, lean=lean)
    return (stage, leaning, replace(camera, readout_s=0.0), frames), rng.choice([0.0, lean])


COMMON = {
    "table tennis": (0.040, 0.0027, 0.7e-3, 0.89),
    "squash": (0.040, 0.024, 4.0e-3, 0.45),
    "golf": (0.0427, 0.0459, 0.5e-3, 0.80),
    "rubber": (0.027, 0.011, 1.3e-3, 0.85),
    "glass": (0.016, 0.0054, 0.05e-3, 0.75),
    "steel": (0.020, 0.0327, 0.05e-3, 0.70),
    "tennis": (0.067, 0.0577, 5.0e-3, 0.74),
    "baseball": (0.0735, 0.145, 1.0e-3, 0.55),
    "foam": (0.070, 0.014, 6.0e-3, 0.60),
    "football": (0.220, 0.430, 9.0e-3, 0.78),
    "basketball": (0.242, 0.62, 13.0e-3, 0.80),
    "handball": (0.190, 0.45, 14.0e-3, 0.70),
}
"""Diameter in m, mass in kg, and how long contacts last, s, with e at 4 m/s: of the sports' rules,
measurements and, of balls full of air, their pressure."""


def of_a_common_ball(kind: str, seed: int) -> tuple[Scene, Ball]:
    """Return a flight of a ball of one kind before a camera, and what a person may state of it."""
    stage, drop, camera, _ = scene("8 bits", seed)
    rng = np.random.default_rng([11, seed, list(COMMON).index(kind)])
    diameter, mass, contact_s, e = COMMON[kind]
    high = rng.uniform(0.5, 1.5)
    start = np.array([0.0, high + 0.5 * diameter, 0.0])
    away = 3.0 * high
    stage = replace(
        stage,
        focal_px=0.85 * stage.size[0] * away / high,
        eye=np.array([0.0, 0.5 * high, -away]),
        look_down=0.0,
    )
    drop = replace(
        drop,
        diameter=diameter,
        mass=mass,
        drag_coefficient=rng.normal(0.47, 0.03),
        start=start,
        speed=np.array([rng.normal(0.0, 0.1), 0.0, rng.normal(0.0, 0.05)]),
        restitution=(e + 0.12, 0.03, 1.0),
        contact_s=contact_s * rng.uniform(0.8, 1.2),
    )
    rate = rng.choice([30.0, 60.0, 120.0, 240.0, 480.0, 960.0])
    camera = replace(camera, rate_hz=rate, readout_s=0.0)
    density = mass / (math.pi / 6 * diameter**3) if rng.uniform() < 0.5 else None
    return (stage, drop, camera, int(rate * rng.uniform(1.2, 2.0))), Ball(diameter, density=density)


def turned(seen: Seen, angle: float) -> Seen:
    """Return places turned about the first, clockwise as they are seen."""
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    return replace(seen, places=(seen.places - seen.places[0]) @ turn.T + seen.places[0])


Writer = Callable[[Seen, Sequence[Bounce]], str]
WRITERS: dict[str, tuple[Writer, bool]] = {
    "Tracker": (lambda seen, _: of_tracker(seen), False),
    "ImageJ": (lambda seen, _: of_imagej(seen), True),
    "TrackMate": (lambda seen, _: of_trackmate(seen), False),
    "trackpy": (of_trackpy, True),
    "DLTdv": (lambda seen, _: of_dltdv(seen), True),
}
"""With whether the frame rate has to be stated."""
ENDS = 6
"""Frames before and after a bounce that a table needs to show it."""


def main() -> None:
    """Print pulls of e by program and by camera."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("--tables", type=int, default=4)
    parser.add_argument("--first", type=int, default=0)
    given = parser.parse_args()
    every: dict[str, list[float]] = {}
    for number, kind in enumerate(KINDS):
        for seed in range(given.first, given.first + given.tables):
            drawn = scene(kind, seed)
            drop = drawn[1]
            density = drop.mass / (math.pi / 6 * drop.diameter**3)
            seen, bounces = tracked(drawn, seed)
            ends = [0.0, *(bounce.time for bounce in bounces), len(seen.frames) / seen.rate_hz]
            lasts = seen.rate_hz * np.diff(np.minimum(ends, ends[-1]))
            whole = [
                bounce
                for bounce, before, after in zip(bounces, lasts[:-1], lasts[1:], strict=True)
                if min(before, after) > ENDS
            ]
            for program, (write, needs_rate) in WRITERS.items():
                ball = Ball(drop.diameter, density=density)
                rate = seen.rate_hz if needs_rate else None
                found = impacts_of(write(seen, bounces), "table.csv", (ball, rate))
                off, lost = pulls(found, whole), max(0, len(whole) - len(found))
                every.setdefault(program, []).extend(off)
                every.setdefault(kind, []).extend(off)
                shown = " ".join(f"{one:+.2f}" for one in off)
                print(f"{kind} {seed} {program}: pulls {shown}; not found {lost}")
            flight = thrown_at_a_wall(drawn, seed)
            seen, bounces = tracked(flight, seed)
            ball = Ball(drop.diameter, density=density)
            off = pulls(impacts_of(of_trackmate(seen), "table.csv", (ball, None)), bounces)
            every.setdefault("TrackMate, thrown at a wall", []).extend(off)
            leaning, upright = on_a_leaning_plate(drawn, seed)
            seen, bounces = tracked(leaning, seed)
            text = of_trackmate(turned(seen, upright))
            off = pulls(impacts_of(text, "table.csv", (ball, None)), bounces)
            every.setdefault("TrackMate, on a leaning plate", []).extend(off)
            shown = " ".join(f"{one:+.2f}" for one in off)
            lean = math.degrees(leaning[1].lean)
            print(f"{kind} {seed} plate leans {lean:+.1f}, upright {upright != 0}: pulls {shown}")
            text, between = heard(drop, 1000 * number + seed)
            off = pulls(impacts_of(text, "Energy.csv", (ball, None)), between)
            every.setdefault("phyphox", []).extend(off)
    for kind in COMMON:
        for seed in range(given.first, given.first + given.tables):
            drawn, ball = of_a_common_ball(kind, seed)
            seen, bounces = tracked(drawn, seed)
            found = impacts_of(of_trackmate(seen), "table.csv", (ball, None))
            off, fast = pulls(found, bounces), pulls(found, bounces, "v_n")
            every.setdefault(f"e of {kind}", []).extend(off)
            every.setdefault("e of common balls", []).extend(off)
            every.setdefault("v_n of common balls", []).extend(fast)
            shown = " ".join(f"{one:+.2f}" for one in off)
            weighed = "known" if ball.density else "unknown"
            print(f"{kind} {seed} at {seen.rate_hz:.0f}/s, mass {weighed}: pulls {shown}")
    for name, off in every.items():
        print(
            f"{name}: {len(off)} bounces, pull {np.sqrt(np.mean(np.square(off))):.2f} rms, "
            f"largest {np.abs(off).max():.1f}"
        )


if __name__ == "__main__":
    main()
