"""Flights over the default sweep beside their truth: python -m benchmarks.tracks --seeds 11 12.

Each seed is a campaign of shots over 25 to 85 kPa and 0 to 18 mm, filmed until the spheres have
left the views, with the scale unstated. Prints for each sphere and axis the rms and the largest
pull of single frames, the share of them beyond 5 stated errors, the pulls of offset and slope of
whole flights with the slow error that the true errors have most likely, the frames that are off by
more than 0.1 mm, and the pulls of the impacts: of velocities and spins by axis, of e, v_n and v_s.
Of each campaign: what the errors of different shots have in common, by the distance of their
places. A pull is an error over its stated one; 1 rms is right. With --folders campaigns of frames
with a truth.json are judged as they lie; where they have perspective, places do not lie where a
plain projection has them, and the impacts count alone.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections import defaultdict
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from analysis.campaign import analyse_campaign, read_campaign
from analysis.shot import AnalysisOptions, MeasuredShot
from benchmarks.tracks.by_place import show_shared
from benchmarks.tracks.flights import Flight, common_scale, flights
from benchmarks.tracks.impacts import impact_pulls
from benchmarks.tracks.pulls import BEYOND, pulls, rms, slow_size
from simulators.world import WorldDescription, write_campaign
from simulators.world.optics import Optics

FRAMES = 112
STEPS = 6
TORN_M = 1e-4
Measured = tuple[MeasuredShot, dict[str, Any]]


def rendered(folder: Path, seed: int, shots: int) -> None:
    """Render a campaign over the ranges of the default sweep in a drawn order."""
    if (folder / "truth.json").exists():
        return
    grid = np.meshgrid(np.linspace(25.0, 85.0, STEPS), np.linspace(0.0, 18.0, STEPS))
    order = np.random.default_rng(seed).permutation(STEPS * STEPS)[:shots]
    pressures, offsets = (axis.ravel()[order].tolist() for axis in grid)
    write_campaign(folder, pressures, offsets, seed, frames=FRAMES, state_scale=False)


def measured(folder: Path, workers: int) -> dict[int, Measured]:
    """Measure a campaign; print what is refused."""
    truths = {s["shot"]: s for s in json.loads((folder / "truth.json").read_text())["shots"]}
    found: dict[int, Measured] = {}
    options = AnalysisOptions(method="photometric")
    for job, shot, _ in analyse_campaign(read_campaign(folder), options, workers=workers):
        if isinstance(shot, MeasuredShot):
            found[job.shot] = shot, truths[job.shot]
        else:
            missed = " (missed in truth)" if truths[job.shot]["missed"] else ""
            print(f"  shot {job.shot} refused at {shot.step}: {shot.reason}{missed}")
    return found


def show(every: list[Flight]) -> None:
    """Print the table of pulls and the torn frames."""
    print(
        f"  {'':16s}{'frames':>8s}{'rms':>7s}{'largest':>9s}{'beyond 5':>10s}{'scatter':>9s}"
        f"{'offset':>8s}{'slope':>7s}{'offset, um, mrad':>18s}{'slope, mm/s, rad/s':>20s}"
        f"{'slow':>9s}"
    )
    for what, unit, per in (("place", 1e6, 1e3), ("turn", 1e3, 1.0)):
        for sphere in (0, 1):
            own = [flight for flight in every if flight.sphere == sphere]
            for axis, name in enumerate("XYZ"):
                p = pulls(own, what, axis)
                beyond = 100 * float((np.abs(p["frame"]) > BEYOND).mean())
                print(
                    f"  {what:6s}{'ab'[sphere]}, {name:6s}{p['frame'].size:9d}"
                    f"{rms(p['frame']):7.2f}{np.abs(p['frame']).max():9.1f}{beyond:9.2f}%"
                    f"{rms(p['scatter']):9.2f}{rms(p['offset']):8.2f}{rms(p['slope']):7.2f}"
                    f"{unit * p['raw_offset'].mean():+9.2f} ({unit * rms(p['raw_offset']):5.2f})"
                    f"{per * rms(p['raw_slope']):14.3f}"
                    f"{unit * slow_size(own, what, axis):15.2f}"
                )
    torn = [
        (flight.shot, flight.sphere, int(k))
        for flight in every
        for k, off in zip(flight.frames, flight.place_errors, strict=True)
        if np.nanmax(np.abs(off), initial=0.0) > TORN_M
    ]
    shots = sorted({shot for shot, _, _ in torn})
    print(f"  frames off by more than {1e3 * TORN_M:g} mm: {len(torn)}, in shots {shots}")


def show_impacts(pulls_: dict[str, list[float]]) -> None:
    """Print the pulls of impacts."""
    for name, own in pulls_.items():
        values = np.array(own)
        print(f"  {name:12s}{len(own):6d}{rms(values):7.2f}, worst {np.abs(values).max():.1f}")


def judged(folder: Path, workers: int) -> tuple[dict[int, Measured], Optics]:
    """Measure a folder; its truths say how long contacts lasted, and its views where they are."""
    camera = read_campaign(folder).jobs[0].setup.camera
    optics = WorldDescription().optics
    if camera.front_origin_px is not None and camera.top_origin_px is not None:
        optics = replace(
            optics, front_origin_px=camera.front_origin_px, top_origin_px=camera.top_origin_px
        )
    found = measured(folder, workers)
    return {n: (s, {"contact_duration_s": 0.0, **truth}) for n, (s, truth) in found.items()}, optics


def main() -> None:
    """Measure, judge and print."""
    parser = argparse.ArgumentParser(prog="benchmarks.tracks", description=__doc__)
    parser.add_argument("--seeds", type=int, nargs="+", default=[11, 12])
    parser.add_argument("--shots", type=int, default=36, help="of each campaign, 36 at most")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--folders", type=Path, nargs="+", help="judge these frames")
    parser.add_argument("--keep", type=Path, help="keep the frames here, and use those there")
    chosen = parser.parse_args()
    every, impacts = list[Flight](), defaultdict[str, list[float]](list)
    with tempfile.TemporaryDirectory() as scratch:
        home = chosen.keep or Path(scratch)
        for folder in chosen.folders or [home / str(seed) for seed in chosen.seeds]:
            if not chosen.folders:
                rendered(folder, int(folder.name), chosen.shots)
            print(folder.name)
            found, optics = judged(folder, chosen.workers)
            shots = list(found.values())
            own_flights = list(flights(list(found), shots, optics))
            every.extend(own_flights)
            first, off = shots[0][0], common_scale(shots, optics)
            for name, own in impact_pulls(shots, off).items():
                impacts[name] += own
            slow_um = 1e6 * first.slow.position_m
            print(f"  {len(shots)} shots, lengths off by {off:+.2e}, stated {first.slow.scale:.2e}")
            print(f"  slow error {slow_um:.2f} um, {1e3 * first.slow.rotation_rad:.3f} mrad")
            show_shared(own_flights)
    show(every)
    show_impacts(impacts)


if __name__ == "__main__":
    main()
