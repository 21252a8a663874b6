"""Coefficients at every rate and format of the recorder: python -m benchmarks.formats.

The simulated pusher rig is filmed at 30 to 1000 full frames a second, and at 1000 with 2 to 6
pictures a frame; below 500 a second with the slowest spheres that still meet in the field. Beside
each stands how far e, v_n, v_s, v_s' and beta lie off the truth in their own standard errors (root
mean square over the shots), their median errors, and why shots were refused.
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from analysis.quantity import Quantity
from analysis.setup import CameraSetup, Environment, Setup, SphereSetup
from analysis.shot import AnalysisOptions, Method, RefusedShot, analyse_shot
from simulators.world import Launch, render_shot
from simulators.world.description import WorldDescription
from simulators.world.optics import Optics
from simulators.world.scene import described

DIAMETER_M = 0.0254
SHOWN_S = 0.05
"""Time of a film about the contact; spheres are in the field for less."""
MOST_FRAMES = 120
SLOW_KPA, FAST_KPA = (14.0, 17.0, 20.0), (30.0, 45.0, 60.0)
SLOW_BELOW_HZ = 500
NAMES = ("e", "v_n", "v_s", "v_s_after", "beta")


@dataclass(frozen=True, slots=True)
class Format:
    """Full frames a second, pictures a frame, and the magnification in px/m."""

    rate: int
    pictures: int = 1
    scale_px_per_m: float = 1574.8

    @property
    def rows(self) -> int:
        """Of a picture."""
        return 192 // self.pictures

    @property
    def pictures_per_s(self) -> float:
        """Pictures recorded a second."""
        return float(self.rate * self.pictures)

    @property
    def has_mirror(self) -> bool:
        """Whether the top view has room beside the front view."""
        return self.pictures == 1


FORMATS = (
    *(Format(rate) for rate in (30, 60, 125, 250, 500, 1000)),
    Format(1000, 2),
    Format(1000, 3, 1181.1),
    Format(1000, 4, 1181.1),
    Format(1000, 6, 787.4),
)


@dataclass(slots=True)
class Found:
    """Errors of each number in its own standard errors, these errors, and refusals."""

    off: dict[str, list[float]] = field(default_factory=lambda: {name: [] for name in NAMES})
    sigma: dict[str, list[float]] = field(default_factory=lambda: {name: [] for name in NAMES})
    refused: Counter[str] = field(default_factory=Counter)

    def add(self, name: str, found: Quantity | None, truth: float) -> None:
        """Add one number of one shot; None where it is open."""
        if found is None:
            return
        self.off[name].append((found.value - truth) / found.sigma)
        self.sigma[name].append(found.sigma)


def world(recorded: Format) -> WorldDescription:
    """Return the nylon rig before a camera that is aimed at the collision."""
    if recorded.has_mirror:
        return WorldDescription(optics=Optics(scale_px_per_m=recorded.scale_px_per_m))
    optics = {"front_view_rows": [0, recorded.rows], "scale_px_per_m": recorded.scale_px_per_m}
    return described({"rows": recorded.rows, "optics": optics})


def setup(recorded: Format) -> Setup:
    """Return what is known before a shot is measured."""
    mirror = recorded.has_mirror
    optics = Optics()
    camera = CameraSetup(
        frame_rate_hz=recorded.pictures_per_s,
        height_px=recorded.rows,
        width_px=optics.columns,
        front_view_rows=optics.front_rows if mirror else (0, recorded.rows),
        top_view_rows=optics.top_rows if mirror else None,
        scale_px_per_m=recorded.scale_px_per_m,
        front_origin_px=optics.front_origin_px if mirror else ((recorded.rows - 1) / 2, 120.0),
        top_origin_px=optics.top_origin_px if mirror else None,
        exposure_s=optics.exposure_s,
    )
    spheres = (SphereSetup("a", DIAMETER_M), SphereSetup("b", DIAMETER_M))
    return Setup(camera, spheres, Environment(drag_coefficient=0.42))


def measure(
    recorded: Format, shots: int, method: Method = "photometric", offset_m: float = 0.006
) -> Found:
    """Film and measure shots of one format."""
    found = Found()
    description, known = world(recorded), setup(recorded)
    frames = min(MOST_FRAMES, max(6, round(SHOWN_S * recorded.pictures_per_s)))
    for number in range(shots):
        slow = recorded.rate < SLOW_BELOW_HZ
        pressure = (SLOW_KPA if slow else FAST_KPA)[number % 3]
        filmed = render_shot(
            description,
            Launch(pressure, pressure, offset_m),
            number + 1,
            frame_rate_hz=recorded.pictures_per_s,
            frames=frames,
            rows=recorded.rows,
        )
        shot = analyse_shot(filmed.frames, filmed.times_s, known, AnalysisOptions(method=method))
        if isinstance(shot, RefusedShot):
            found.refused[f"{shot.step}: {shot.reason}"] += 1
            continue
        truth = filmed.truth
        found.add("e", shot.impact.e, -truth["v_n_after"] / truth["v_n"])
        found.add("beta", shot.impact.beta, -truth["v_s_after"] / truth["v_s"])
        for name in ("v_n", "v_s", "v_s_after"):
            found.add(name, getattr(shot.impact, name), truth[name])
    return found


def errors(found: Found, name: str) -> str:
    """Return the root mean square of off/sigma and the median sigma as text."""
    if not found.off[name]:
        return "     -      -"
    off = float(np.sqrt(np.mean(np.square(found.off[name]))))
    return f"{off:6.2f} {np.median(found.sigma[name]):.4f}"


def main() -> None:
    """Print one line for each format."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--shots", type=int, default=6)
    parser.add_argument("--only", help="one format, as 1000x1: frames a second x pictures a frame")
    asked = parser.parse_args()
    shots = asked.shots
    heads = "  ".join(f"{name + ': off, σ':>15}" for name in NAMES)
    print(f"frames/s x pictures  rows  px/ball  measured  {heads}")
    for recorded in FORMATS:
        if asked.only not in {None, f"{recorded.rate}x{recorded.pictures}"}:
            continue
        found = measure(recorded, shots)
        told = "  ".join(f"{errors(found, name):>15}" for name in NAMES)
        print(
            f"{recorded.rate:8d} x {recorded.pictures}         {recorded.rows:4d} "
            f"{recorded.scale_px_per_m * DIAMETER_M:7.0f}   {len(found.off['e']):3d}/{shots}  "
            f"{told}"
        )
        for reason, count in found.refused.most_common(2):
            print(f"    {count} refused, {reason}")


if __name__ == "__main__":
    main()
