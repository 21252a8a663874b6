"""Speed on one core, warm: whole frames with two spheres in two views and all markers."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.campaign import read_campaign
from analysis.imaging.edge.frame import EdgeSettings
from analysis.imaging.files.stack import read_stack
from analysis.photometric.follow.film import fit_film
from analysis.photometric.method import compiles_first, followed_film
from analysis.photometric.teaching import teach
from analysis.shot import AnalysisOptions, Method, analyse_shot
from analysis.tracking import track_spheres
from benchmarks.imaging.goals import Sheet
from simulators.world import write_campaign
from simulators.world.description import WorldDescription
from simulators.world.optics import Optics

FRAMES = 24
SIGMA_PX = 2.0
LARGE, LARGE_DIAMETER_PX = (800, 1280), 60.0
"""Rows and columns of a camera of today, and its spheres' size."""


def run(seed: int) -> None:
    """Time learning, fitting and whole shots; each is the best of several runs."""
    sheet = Sheet("speed")
    with tempfile.TemporaryDirectory() as scratch:
        write_campaign(Path(scratch), [60.0, 40.0], [5.0, 9.0], seed, frames=FRAMES)
        jobs = tuple(read_campaign(Path(scratch)).jobs)
        first, second = (read_stack(job.frames).pixels for job in jobs)
    setup, times_s = jobs[0].setup, np.arange(FRAMES) / jobs[0].setup.camera.frame_rate_hz
    print(f"\nprocessor time, {'compiling' if compiles_first() else 'compiled before'}")
    started = time.process_time()
    known = teach([(first, times_s, setup)])
    if known is None:
        raise SystemExit("the rendered pair cannot be learned")
    film = followed_film(second, times_s, known)
    sheet.at_most("first use", time.process_time() - started, 15.0, "s")
    start, whole = film.centre.copy(), int(film.placed.all(axis=0).sum())

    def fit() -> None:
        film.centre[:] = start + 0.1 / known.camera.optics.scales[0]
        fit_film(film, known, np.array([6.0, 6.0]))

    def shot(method: Method) -> float:
        options = AnalysisOptions(method=method)
        return 1e3 * best_of(15, lambda: analyse_shot(second, times_s, setup, options, known))

    def track() -> None:
        track_spheres(second, times_s, setup, EdgeSettings(), "pattern")

    sheet.at_least("photometric, from predictions", whole / best_of(30, fit), 1000.0, "frames/s")
    sheet.at_least("thesis, pixels to poses", FRAMES / best_of(15, track), 2000.0, "frames/s")
    alone = _filtered_by_opencv(second)
    print(f"  OpenCV's 17 x 17 filter alone, beside it: {alone:.0f} frames/s")
    sheet.at_most(f"a shot of {FRAMES} frames, known pair", shot("photometric"), 60.0, "ms")
    print(f"  the same by edges: {shot('thesis'):.0f} ms")
    learning = 1e3 * best_of(5, lambda: teach([(first, times_s, setup)]))
    sheet.at_most("learning a pair", learning, 500.0, "ms")
    sheet.write()


def large(seed: int) -> None:
    """Time whole shots of large pictures, once the pair is known."""
    sheet = Sheet("large")
    with tempfile.TemporaryDirectory() as scratch:
        description = WorldDescription(optics=_large_optics())
        pressures_kpa, offsets_mm = [60.0, 40.0], [5.0, 9.0]
        write_campaign(
            Path(scratch), pressures_kpa, offsets_mm, seed, description=description, frames=FRAMES
        )
        jobs = tuple(read_campaign(Path(scratch)).jobs)
        first, second = (read_stack(job.frames).pixels for job in jobs)
        reading = best_of(5, lambda: read_stack(jobs[1].frames))
    setup, times_s = jobs[0].setup, np.arange(FRAMES) / jobs[0].setup.camera.frame_rate_hz
    known = teach([(first, times_s, setup)])
    if known is None:
        print("  of large pictures: the rendered pair cannot be learned")
        return
    options = AnalysisOptions(method="photometric")
    seconds = best_of(25, lambda: analyse_shot(second, times_s, setup, options, known))
    name = f"{LARGE[1]} x {LARGE[0]}, spheres of {LARGE_DIAMETER_PX:.0f} px, known pair"
    sheet.at_least(name, FRAMES / seconds, 200.0, "frames/s")
    print(f"  reading the file alone, beside it: {FRAMES / reading:.0f} frames/s")
    sheet.write()


def _large_optics() -> Optics:
    """Return optics of large pictures: the spheres' own scale, both views in their middle."""
    plain, sphere = Optics(), WorldDescription().sphere_a
    rows, columns = LARGE
    times = LARGE_DIAMETER_PX / (2.0 * sphere.radius_m * plain.scale_px_per_m)
    shift = 0.5 * (rows - times * plain.rows)
    boundary = round(times * plain.front_rows[0] + shift)
    return replace(
        plain,
        rows=rows,
        columns=columns,
        scale_px_per_m=times * plain.scale_px_per_m,
        front_origin_px=(times * plain.front_origin_px[0] + shift, 0.5 * columns),
        top_origin_px=(times * plain.top_origin_px[0] + shift, 0.5 * columns),
        front_rows=(boundary, rows),
        top_rows=(0, boundary),
    )


def _filtered_by_opencv(film: NDArray[np.uint8]) -> float:
    """Return how many whole frames a second OpenCV filters with the thesis's operator."""
    across = np.arange(-8.0, 9.0)
    square = across**2 + across[:, None] ** 2
    kernel = (square / SIGMA_PX**2 - 2.0) * np.exp(-square / (2.0 * SIGMA_PX**2))

    def filtered() -> None:
        for frame in film:
            cv2.filter2D(frame, cv2.CV_32F, kernel)

    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        return len(film) / best_of(15, filtered)
    finally:
        cv2.setNumThreads(threads)


def best_of(runs: int, task: Callable[[], object]) -> float:
    """Return the shortest of several processor times, s; what else the machine does only adds."""
    times = []
    for _ in range(runs):
        started = time.process_time()
        task()
        times.append(time.process_time() - started)
    return min(times)
