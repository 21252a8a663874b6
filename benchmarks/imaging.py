"""Centre and turn errors beside the Cramer-Rao bound: python benchmarks/imaging.py.

Spheres of 40 pixels are ray-cast by the simulators, blurred, given read noise and rounded. Row and
column (turns) are fitted with gain, offset and slopes of the light unknown; the bound is that of
the same unknowns, from derivatives of the ray-cast images. OpenCV's circles stand beside, and
those of scikit-image and trackpy where they are installed.

Then the speed, beside its goals, on rendered shots of 24 frames: whole frames with two spheres in
two views fitted in two steps from their prediction, a shot of known spheres from frames to
coefficients, and learning a pair. Each is the best of several runs. Writes imaging.json.
"""

from __future__ import annotations

import argparse
import importlib
import json
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.campaign import read_campaign
from analysis.imaging.stack import read_stack
from analysis.motion.rotation import rotation_matrix, rotation_vector
from analysis.photometric.camera import Optics
from analysis.photometric.film import fit_film
from analysis.photometric.method import compiles_first, followed_film, teach
from analysis.photometric.pose import fit_pose
from analysis.photometric.shading import HARMONICS, RADIALS, blurred_profiles, template
from analysis.photometric.sight import Look, Scene, Sight, Stance
from analysis.photometric.surface import draw
from analysis.shot import AnalysisOptions, Method, analyse_shot
from simulators.world import write_campaign
from simulators.world.disc import SUBPIXELS, Disc
from simulators.world.markers import scatter_markers
from simulators.world.optics import Lighting

Floats = NDArray[np.float64]

SIZE, RADIUS, ALPHA, REFLECTANCE = 64, 20.0, 0.16, 0.3
BACKGROUND, BRIGHTNESS, LIMB, SIDE, BLUR = 40.0, 140.0, 0.3, 0.1, 0.9
LIMITS = np.array([40.0, 10.0, 6.0, 6.0])
LIGHT = Lighting(BRIGHTNESS, LIMB, SIDE, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class Case:
    """What is drawn, and the most that the error may exceed the bound by."""

    name: str
    noise: float
    markers: int
    goal: float


CASES = (
    Case("plain, noise 2", 2.0, 0, 1.15),
    Case("16 markers, noise 2", 2.0, 16, 1.25),
    Case("plain, noise 5", 5.0, 0, 1.25),
    Case("16 markers, noise 5", 5.0, 16, 1.25),
)


def drawn(place: Floats, markers: Floats) -> Floats:
    """Return the image without noise; place as (row, column), directions (row, column, eye)."""
    canvas = np.full((SIZE * SUBPIXELS,) * 2, BACKGROUND, dtype=np.float32)
    centre = (float(place[0]), float(place[1]))
    Disc(centre, RADIUS, markers, ALPHA, REFLECTANCE, LIGHT).paint(canvas, (0, 0))
    light = canvas.reshape(SIZE, SUBPIXELS, SIZE, SUBPIXELS).mean(axis=(1, 3))
    return cv2.GaussianBlur(light, (0, 0), BLUR).astype(np.float64)


def with_noise(image: Floats, noise: float, rng: np.random.Generator) -> NDArray[np.uint8]:
    return np.clip(np.rint(image + noise * rng.normal(size=image.shape)), 0, 255).astype(np.uint8)


def sight_of(image: NDArray[np.uint8], markers: Floats, noise: float) -> Sight:
    """Return the frame with what is known: radius, blur, shading and marker pattern."""
    shares = {(0, 0, 0): 1 - LIMB, (0, 0, 1): LIMB}
    side = {(1, 1, 0): SIDE * (1 - LIMB), (1, 1, 1): SIDE * LIMB}
    coefficients = [
        BRIGHTNESS
        * (side if sine else shares).get(
            (RADIALS[j].angular, RADIALS[j].power, RADIALS[j].height), 0.0
        )
        for j, sine in HARMONICS
    ]
    wide = float(np.hypot(BLUR, 12**-0.5))
    table = template(blurred_profiles(wide / RADIUS), np.array(coefficients))
    discs, surfaces = draw([table], np.zeros((1, 17, 17)), RADIUS)
    look = Look(
        radius_m=1.0,
        markers=markers,
        alpha=ALPHA,
        darkness=1.0 - REFLECTANCE,
        discs=discs,
        surfaces=surfaces,
        sigma_px=np.array([wide]),
    )
    rows = np.array([[0, SIZE]])
    optics = Optics(np.eye(3)[None], np.zeros((1, 2)), np.array([RADIUS]), np.ones(1), rows)
    background = np.full(image.shape, BACKGROUND)
    return Sight(Scene(image, background, noise), optics, look, np.zeros((1, 0, 3)))


def fitted(sight: Sight, near: Floats, turn: Floats) -> tuple[Stance, Floats, float]:
    """Fit from a start 0.3 pixels and 1 degree away; return stance, covariance and seconds."""
    centre = np.array([*(near + 0.2) / RADIUS, 0.0])
    start = rotation_matrix(np.array([0.01, -0.01, 0.01])) @ turn
    stance = Stance(centre, start, np.array([[0.0, 1.0, 0.0, 0.0]]))
    covariance = np.zeros((6, 6))
    started = time.perf_counter()
    fit_pose(sight, stance, LIMITS, covariance)
    return stance, covariance, time.perf_counter() - started


def bound(place: Floats, markers: Floats, noise: float) -> Floats:
    """Return the least standard errors of row, column (pixels) and turns (radians)."""
    step = 0.02

    def at(change: Floats) -> Floats:
        return drawn(place + change[:2], markers @ rotation_matrix(change[2:5]).T).ravel()

    columns = []
    for k in range(5 if len(markers) else 2):
        change = np.zeros(5)
        change[k] = step
        columns.append((at(change) - at(-change)) / (2 * step))
    y, x = (np.mgrid[:SIZE, :SIZE] - place[:, None, None]) / RADIUS
    disc = np.clip((1 - np.hypot(y, x)) * RADIUS + 0.5, 0, 1)
    columns += [(1 - disc).ravel(), (drawn(place, markers) * disc).ravel()]
    columns += [(disc * y).ravel(), (disc * x).ravel()]
    jacobian = np.stack(columns, axis=1)
    covariance = np.linalg.inv(jacobian.T @ jacobian) * (noise**2 + 1 / 12)
    return np.sqrt(np.diag(covariance))[: 5 if len(markers) else 2]


def hough(image: NDArray[np.uint8]) -> Floats:
    found = cv2.HoughCircles(
        image, cv2.HOUGH_GRADIENT_ALT, 1, 30, param1=100, param2=0.6, minRadius=15, maxRadius=25
    )
    return np.full(2, np.nan) if found is None else np.asarray(found[0, 0, 1::-1], dtype=np.float64)


def enclosing(image: NDArray[np.uint8]) -> Floats:
    _, mask = cv2.threshold(image, 0, 255, cv2.THRESH_OTSU)
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    (x, y), _ = cv2.minEnclosingCircle(max(outlines, key=len))
    return np.array([y, x])


def others() -> dict[str, Callable[[NDArray[np.uint8]], Floats]]:
    """Return the methods to compare with, of the libraries that are installed."""
    methods = {"OpenCV Hough": hough, "OpenCV enclosing circle": enclosing}
    for name, build in (("skimage", _skimage), ("trackpy", _trackpy)):
        try:
            methods[name] = build(importlib.import_module(name))
        except ImportError:
            print(f"{name} is not installed")
    return methods


def _skimage(_: object) -> Callable[[NDArray[np.uint8]], Floats]:
    feature = importlib.import_module("skimage.feature")
    transform = importlib.import_module("skimage.transform")

    def locate(image: NDArray[np.uint8]) -> Floats:
        radii = np.arange(18, 23)
        votes = transform.hough_circle(feature.canny(image, 2.0), radii)
        _, x, y, _ = transform.hough_circle_peaks(votes, radii, total_num_peaks=1)
        return np.array([y[0], x[0]], dtype=np.float64)

    return locate


def _trackpy(library: object) -> Callable[[NDArray[np.uint8]], Floats]:
    def locate(image: NDArray[np.uint8]) -> Floats:
        found = library.locate(image, 45, preprocess=False, topn=1)  # type: ignore[attr-defined]
        return np.asarray(found[["y", "x"]].to_numpy()[0])

    return locate


def measure(case: Case, images: int, seed: int) -> dict[str, object]:
    """Fit one case many times, print its lines and return its figures."""
    rng = np.random.default_rng(seed)
    errors, pulls, bounds, seconds = [], [], [], []
    rivals: dict[str, list[Floats]] = {name: [] for name in others()}
    methods = others()
    for _ in range(images):
        place = SIZE / 2 + rng.uniform(-0.5, 0.5, 2)
        pattern = scatter_markers(case.markers, rng) if case.markers else np.zeros((0, 3))
        image = with_noise(drawn(place, pattern), case.noise, rng)
        sight = sight_of(image, pattern, float(np.hypot(case.noise, 12**-0.5)))
        stance, covariance, spent = fitted(sight, place, np.eye(3))
        used = [0, 1, 3, 4, 5] if case.markers else [0, 1]
        error = np.concatenate(
            [stance.centre[:2] * RADIUS - place, rotation_vector(stance.rotation)]
        )
        sigma = np.sqrt(np.diag(covariance))[used] * np.where(np.array(used) < 2, RADIUS, 1.0)
        errors.append(error[: len(used)])
        pulls.append(error[: len(used)] / sigma)
        bounds.append(bound(place, pattern, case.noise))
        seconds.append(spent)
        for name, method in methods.items():
            rivals[name].append(method(image) - place)
    rms = np.sqrt((np.array(errors) ** 2).mean(axis=0))
    least = np.sqrt((np.array(bounds) ** 2).mean(axis=0))
    ratio = float(np.sqrt((rms[:2] ** 2).sum() / (least[:2] ** 2).sum()))
    pull = float(np.sqrt((np.array(pulls) ** 2).mean()))
    print(f"\n{case.name}: centre {rms[:2].mean():.4f} px, bound {least[:2].mean():.4f} px")
    print(f"  ratio {ratio:.2f}, goal {case.goal:.2f}; pull {pull:.2f}", end="")
    print(f"; {1e3 * np.median(seconds):.2f} ms a fit of {len(LIMITS)} steps")
    figures: dict[str, object] = {"case": case.name, "ratio": ratio, "pull": pull}
    if case.markers:
        turns = np.degrees([np.sqrt((v[2:] ** 2).sum()) for v in (rms, least)])
        print(f"  turn {turns[0]:.3f} degrees over three axes, bound {turns[1]:.3f}")
        print(f"  between two frames {np.sqrt(2) * turns[0]:.3f} degrees")
        figures["turn_deg"], figures["turn_bound_deg"] = map(float, turns)
    for name, offs in rivals.items():
        other = float(np.sqrt(np.nanmean(np.array(offs) ** 2)))
        print(f"  {name}: {other:.3f} px, {other / least[:2].mean():.0f} bounds")
    return figures


def best_of(runs: int, task: Callable[[], object]) -> float:
    """Return the shortest of several times, s; what else the machine does only adds."""
    times = []
    for _ in range(runs):
        started = time.perf_counter()
        task()
        times.append(time.perf_counter() - started)
    return min(times)


def measure_speed(seed: int) -> dict[str, float]:
    """Time learning, fitting and whole shots, print them beside their goals and return them."""
    with tempfile.TemporaryDirectory() as scratch:
        write_campaign(Path(scratch), [60.0, 40.0], [5.0, 9.0], seed, frames=24)
        jobs = read_campaign(Path(scratch)).jobs
        first, second = (read_stack(job.frames).pixels for job in jobs)
    setup, times_s = jobs[0].setup, np.arange(len(first)) / jobs[0].setup.camera.frame_rate_hz
    compiles = compiles_first()
    started = time.perf_counter()
    known = teach([(first, times_s)], setup)
    if known is None:
        raise SystemExit("the rendered pair cannot be learned")
    followed_film(second, times_s, known)
    spent = time.perf_counter() - started
    print(f"\nfirst use {spent:.1f} s, {'compiling' if compiles else 'compiled before'}; goal 15 s")
    film = followed_film(second, times_s, known)
    whole = int(film.placed.all(axis=0).sum())
    start = film.centre.copy()

    def fit() -> None:
        film.centre[:] = start + 0.1 / known.camera.optics.scales[0]
        fit_film(film, known, np.array([6.0, 6.0]))

    def shot(method: Method) -> float:
        options = AnalysisOptions(method=method)
        return best_of(5, lambda: analyse_shot(second, times_s, setup, options, known))

    figures = {
        "frames_per_s": whole / best_of(20, fit),
        "shot_ms": 1e3 * shot("photometric"),
        "thesis_shot_ms": 1e3 * shot("thesis"),
        "learning_ms": 1e3 * best_of(3, lambda: teach([(first, times_s)], setup)),
        "first_use_s": spent,
    }
    print(f"fit {figures['frames_per_s']:.0f} frames/s; goal 1000")
    print(f"known pair {figures['shot_ms']:.0f} ms a shot of {len(second)} frames; goal 60")
    print(f"  by edges {figures['thesis_shot_ms']:.0f} ms")
    print(f"learning a pair {figures['learning_ms']:.0f} ms; goal 500")
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--images", type=int, default=200, help="images for each case")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path, default=Path("out/imaging.json"))
    chosen = parser.parse_args()
    cases = [measure(case, chosen.images, chosen.seed) for case in CASES]
    figures = {"cases": cases, "speed": measure_speed(chosen.seed)}
    chosen.json.parent.mkdir(parents=True, exist_ok=True)
    chosen.json.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()
