"""Errors of centres and turns beside the Cramer-Rao bound, and how true the stated ones are.

Row and column (turns) are fitted with gain, offset and slopes of the light unknown; the bound is
that of the same unknowns, from derivatives of the ray-cast images.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.motion.rotation import rotation_vector
from benchmarks.imaging.drawing import RADIUS, SIZE, bound, drawn, fitted, sight_of, with_noise
from benchmarks.imaging.goals import Sheet
from benchmarks.imaging.rivals import others
from simulators.world.markers import scatter_markers

Floats = NDArray[np.float64]

NEAR_PX, NINETY_FIVE = 0.05, 1.959964


@dataclass(frozen=True, slots=True)
class Case:
    """What is drawn, and the most that the error may exceed the bound by."""

    name: str
    noise: float
    markers: int
    goal: float
    smear_px: float = 0.0


CASES = (
    Case("plain, noise 2", 2.0, 0, 1.15),
    Case("8 markers, noise 2", 2.0, 8, 1.25),
    Case("16 markers, noise 2", 2.0, 16, 1.25),
    Case("plain, noise 5", 5.0, 0, 1.25),
    Case("16 markers, noise 5", 5.0, 16, 1.25),
    Case("plain, smeared over 3.7 px", 2.0, 0, 1.25, 3.7),
    Case("8 markers, smeared over 3.7 px", 2.0, 8, 1.25, 3.7),
    Case("16 markers, smeared over 3.7 px", 2.0, 16, 1.25, 3.7),
)


def run(images: int, seed: int) -> None:
    """Measure all cases."""
    sheet = Sheet("centres")
    for case in CASES:
        measure(case, images, seed, sheet)
    sheet.write()


def measure(case: Case, images: int, seed: int, sheet: Sheet) -> None:
    """Fit one case many times and print its lines."""
    rng, methods = np.random.default_rng(seed), others()
    rivals: dict[str, list[Floats]] = {name: [] for name in methods}
    errors, pulls, bounds = [], [], []
    used = [0, 1, 3, 4, 5] if case.markers else [0, 1]
    for _ in range(images):
        place = SIZE / 2 + rng.uniform(-0.5, 0.5, 2)
        pattern = scatter_markers(case.markers, rng) if case.markers else np.zeros((0, 3))
        image = with_noise(drawn(place, pattern, case.smear_px), case.noise, rng)
        sight = sight_of(image, pattern, float(np.hypot(case.noise, 12**-0.5)), case.smear_px)
        stance, covariance = fitted(sight, place, np.eye(3))
        error = np.concatenate(
            [stance.centre[:2] * RADIUS - place, rotation_vector(stance.rotation)]
        )[: len(used)]
        sigma = np.sqrt(np.diag(covariance))[used] * np.where(np.array(used) < 2, RADIUS, 1.0)
        errors.append(error)
        pulls.append(error / sigma)
        bounds.append(bound(place, pattern, case.noise, case.smear_px))
        for name, method in methods.items():
            rivals[name].append(method(image) - place)
    report(case, (np.array(errors), np.array(pulls), np.array(bounds)), rivals, sheet)


def report(
    case: Case,
    found: tuple[Floats, Floats, Floats],
    rivals: dict[str, list[Floats]],
    sheet: Sheet,
) -> None:
    """Print a case's lines: errors, pulls and bounds of shape (images, unknowns)."""
    errors, pulls, bounds = found
    rms, least = (np.sqrt((part**2).mean(axis=0)) for part in (errors, bounds))
    print(f"\n{case.name}: centre {rms[:2].mean():.4f} px, bound {least[:2].mean():.4f} px")
    ratio = float(np.sqrt((rms[:2] ** 2).sum() / (least[:2] ** 2).sum()))
    sheet.at_most(f"{case.name}: centre over bound", ratio, case.goal)
    near = float((np.hypot(errors[:, 0], errors[:, 1]) < NEAR_PX).mean())
    if case.noise == 2.0 and case.smear_px == 0.0:
        sheet.at_most(f"{case.name}: centre", float(rms[:2].mean()), 0.010, "px")
        sheet.at_least(f"{case.name}: within {NEAR_PX} px", 100 * near, 99.0, "%")
    sheet.at_most(
        f"{case.name}: stated error off by", 100 * abs(np.sqrt((pulls**2).mean()) - 1), 10.0, "%"
    )
    covered = 100 * float((np.abs(pulls) < NINETY_FIVE).mean())
    sheet.at_least(f"{case.name}: 95 % intervals cover", covered, 93.0, "%")
    sheet.at_most(f"{case.name}: 95 % intervals cover", covered, 97.0, "%")
    if case.markers:
        turns = np.degrees([np.sqrt((v[2:] ** 2).sum()) for v in (rms, least)])
        sheet.at_most(f"{case.name}: turn over bound", turns[0] / turns[1], case.goal)
    for name, offs in rivals.items():
        other = float(np.sqrt(np.nanmean(np.array(offs) ** 2)))
        print(f"  {name}: {other:.3f} px, {other / least[:2].mean():.0f} bounds")
