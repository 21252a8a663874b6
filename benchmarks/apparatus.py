"""Every apparatus of the thesis, fired on the simulators: python -m benchmarks.apparatus.

Each configuration fires shots over its range through the real drivers; what is measured of each
shot by itself is held against what the simulated world wrote down of it. Prints, for e, v_n, v_s,
v_s' and beta, how far they lie off the truth in their own standard errors (root mean square, and
the worst), and their median errors; below, the same in the part of these errors that belongs to the
shot alone, without what all shots share (scale, drag); every refused shot with its reason; and what
processor time a shot took, the start of the daemon and its workers among it.
--diameter-mm and --gravity change all of them, offsets in proportion to the diameter: 12.7 and 1.62
are half an inch on the Moon. --pictures splits each frame of simulated-split into so many. --seed
draws another world; --keep FOLDER keeps its shots; --each prints every shot.
Ends 1 if a number is off by more than four of its errors, or no shot of an apparatus was measured.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from rigctl import logs
from rigctl.config import Configuration, StoreSection, load
from rigctl.config.camera import EKTAPRO_ROWS, EktaproCamera
from rigctl.daemon import Daemon, open_daemon
from rigctl.errors import RigError
from rigctl.firing import fire_and_wait
from rigctl.local import LocalRig
from rigctl.settings import ShotSettings

CONFIG = Path(__file__).parents[1] / "config"
OUT = Path("out/apparatus.json")
NAMES = ("e", "v_n", "v_s", "v_s_after", "beta")
MOST_OFF = 4.0
WAIT_S = 600.0
CAMPAIGN = "benchmark"
AFTER_MARK = 100
"""Frames after the mark, of one picture each."""

Json = Mapping[str, Any]


def shots_of(name: str, count: int) -> Iterator[ShotSettings]:
    """Yield settings spread over what an apparatus is used for."""
    share = np.linspace(0.0, 1.0, count) if count > 1 else np.array([0.5])
    # Offsets in another order than pressures: neither goes with the other.
    other = np.roll(share[::-1], 1)
    ranges = {
        "simulated": ((30.0, 70.0), (3.0, 9.0)),
        "simulated-split": ((35.0, 65.0), (5.0, 9.0)),
        "simulated-small": ((20.0, 26.0), (0.9, 1.4)),
    }
    for first, second in zip(share, other, strict=True):
        if name in ranges:
            (low, high), (least, most) = ranges[name]
            pressure, offset = low + first * (high - low), least + second * (most - least)
            yield _settings(round(pressure, 2), round(offset, 3))
        elif name == "simulated-release":
            yield _settings(0.0, 0.0, angle_deg=round(26.0 + 8.0 * first, 1))
        else:
            yield _settings(0.0, 0.0)


APPARATUS = (
    "simulated", "simulated-release", "simulated-plate", "simulated-split", "simulated-small",
)  # fmt: skip
"""Configurations whose shots are impacts; `rigctl qualify` has the others."""


@dataclass(slots=True)
class Found:
    """Of one apparatus: errors in their own standard errors, these errors, and refusals."""

    off: dict[str, list[float]] = field(default_factory=lambda: {name: [] for name in NAMES})
    sigma: dict[str, list[float]] = field(default_factory=lambda: {name: [] for name in NAMES})
    own_off: dict[str, list[float]] = field(default_factory=lambda: {name: [] for name in NAMES})
    own_sigma: dict[str, list[float]] = field(default_factory=lambda: {name: [] for name in NAMES})
    measured: int = 0
    refused: list[str] = field(default_factory=list)
    each: list[str] = field(default_factory=list)
    cpu_s: float = 0.0

    def add(self, impact: Json, truth: Json) -> None:
        """Add one impact; what is not known has no value."""
        e, words = -truth["v_n_after"] / truth["v_n"], []
        beta = -truth["v_s_after"] / truth["v_s"] if truth["v_s"] else np.nan
        for name in NAMES:
            true = {"e": e, "beta": beta}.get(name, truth.get(name))
            own = impact.get(name) or {}
            if own.get("value") is None:
                continue
            for sigma, off, errors in (
                (own["sigma"], self.off, self.sigma),
                (own.get("sigma_own"), self.own_off, self.own_sigma),
            ):
                if sigma:
                    off[name].append((own["value"] - true) / sigma)
                    errors[name].append(sigma)
            words.append(f"{name} {own['value']:.5f}({own['sigma']:.5f}), true {true:.5f}")
        self.each.append("; ".join(words))

    @property
    def holds(self) -> bool:
        """Whether something was measured and nothing is far off."""
        every = [abs(value) for values in self.off.values() for value in values]
        return self.measured > 0 and max(every, default=0.0) <= MOST_OFF


def fire(daemon: Daemon, settings: ShotSettings, truths: Path, found: Found) -> None:
    """Fire one shot and hold it against its world."""
    try:
        shot = fire_and_wait(LocalRig(daemon, "benchmark"), settings, CAMPAIGN, WAIT_S, _unseen)
    except RigError as error:
        found.refused.append(error.sentence())
        return
    result = shot["result"]
    if result is None or result["status"] != "measured":
        found.refused.append(str(shot["failure"] or (result or {}).get("reason")))
        return
    truth = json.loads(truths.read_text(encoding="utf-8").splitlines()[-1])
    found.measured += 1
    if "impacts" not in result:
        found.add(result, truth)
        return
    for impact, true in zip(result["impacts"], truth["impacts"], strict=False):
        found.add(impact, true)


def measure(name: str, options: argparse.Namespace) -> Found:
    """Fire the shots of one apparatus, in a store of their own."""
    found, began_s = Found(), _cpu_s()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep / name if options.keep else Path(temporary)
        usual = load(CONFIG / f"{name}.toml")
        configuration = _in_store(_in_world(usual, options), folder / "data")
        size = configuration.spheres[0].diameter_m / usual.spheres[0].diameter_m
        with open_daemon(configuration) as daemon:
            truths = folder / "data/laboratory/truth/truth.jsonl"
            for settings in shots_of(name, options.shots):
                offset = round(settings.offset_mm * size, 3)
                fire(daemon, settings.model_copy(update={"offset_mm": offset}), truths, found)
    found.cpu_s = (_cpu_s() - began_s) / options.shots
    return found


def _cpu_s() -> float:
    """Return the processor time of this process and of those that it has ended, s."""
    return sum(os.times()[:4])


def line(name: str, count: int, found: Found) -> str:
    """Return the two lines of an apparatus."""
    whole, own = cells(found.off, found.sigma), cells(found.own_off, found.own_sigma)
    measured = f"{found.measured:3d}/{count:<3d}"
    return f"{name:<18} {measured}  {whole}   {found.cpu_s:5.1f}\n{'  alone':<18} {'':7}  {own}"


def cells(offs: Mapping[str, list[float]], sigmas: Mapping[str, list[float]]) -> str:
    """Return, for each quantity, rms and worst of what it is off, and the median error, as text."""
    told = []
    for name in NAMES:
        off = np.abs(offs[name])
        told.append(
            f"{np.sqrt(np.mean(off**2)):5.2f} {off.max():5.2f} {np.median(sigmas[name]):8.5f}"
            if off.size
            else f"{'-':>5} {'-':>5} {'-':>8}"
        )
    return "   ".join(told)


def main() -> int:
    """Print one line for each apparatus, and write the findings."""
    asked = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    asked.add_argument("--shots", type=int, default=6)
    asked.add_argument("--only", choices=APPARATUS)
    asked.add_argument("--diameter-mm", type=float, help="of both spheres (the configuration's)")
    asked.add_argument("--gravity", type=float, help="downwards, m/s^2 (the configuration's)")
    asked.add_argument("--pictures", type=int, choices=(1, 2, 3, 4, 6), help="of each frame")
    asked.add_argument("--seed", type=int, help="of the simulated world (the configuration's)")
    asked.add_argument("--keep", type=Path, metavar="FOLDER", help="keep the shots there")
    asked.add_argument("--each", action="store_true", help="print every shot")
    options = asked.parse_args()
    if options.pictures is not None and options.only != "simulated-split":
        asked.error("--pictures is for the split format: add --only simulated-split")
    logs.set_up("text")
    heads = "   ".join(f"{name + ': rms, worst, σ':>20}" for name in NAMES)
    print(f"{'apparatus':<18} measured {heads}   CPU s a shot")
    all_found: dict[str, Found] = {}
    for name in APPARATUS if options.only is None else (options.only,):
        found = all_found[name] = measure(name, options)
        print(line(name, options.shots, found), flush=True)
        for shot in found.each if options.each else ():
            print(f"    {shot}", flush=True)
        for reason in found.refused:
            print(f"    refused: {reason}", flush=True)
    OUT.parent.mkdir(parents=True, exist_ok=True)
    written = {
        name: {"off": found.off, "sigma": found.sigma, "refused": found.refused}
        for name, found in all_found.items()
    }
    OUT.write_text(json.dumps(written, indent=1) + "\n", encoding="utf-8")
    return 0 if all(found.holds for found in all_found.values()) else 1


def _settings(
    pressure_kpa: float, offset_mm: float, angle_deg: float | None = None
) -> ShotSettings:
    return ShotSettings(
        pressure_a_kpa=pressure_kpa,
        pressure_b_kpa=pressure_kpa,
        offset_mm=offset_mm,
        angle_a_deg=angle_deg,
        angle_b_deg=angle_deg,
    )


def _in_world(usual: Configuration, options: argparse.Namespace) -> Configuration:
    """Return a configuration with the spheres, the gravity and the seed that were asked for."""
    changed: dict[str, Any] = {}
    if options.diameter_mm is not None:
        changed["spheres"] = tuple(
            sphere if sphere.plate else replace(sphere, diameter_m=1e-3 * options.diameter_mm)
            for sphere in usual.spheres
        )
    if options.gravity is not None:
        changed["environment"] = replace(usual.environment, gravity_m_per_s2=options.gravity)
    if options.pictures is not None and isinstance(usual.camera, EktaproCamera):
        changed["camera"] = usual.camera.model_copy(
            update={
                "pictures_per_frame": options.pictures,
                "rows": EKTAPRO_ROWS // options.pictures,
                "frames_after_mark": AFTER_MARK * options.pictures,
            }
        )
        # The middle of the full frame, as in the split format's own configuration.
        rows = EKTAPRO_ROWS // options.pictures
        origin = rows / 2, usual.camera.columns / 2
        changed["optics"] = usual.optics.model_copy(
            update={"front_view_rows": (0, rows), "front_origin_px": origin}
        )
    if options.seed is not None and usual.simulation is not None:
        changed["simulation"] = usual.simulation.model_copy(update={"seed": options.seed})
    return usual.model_copy(update=changed)


def _in_store(configuration: Configuration, folder: Path) -> Configuration:
    """Return a configuration with its store, and time for a world on a busy host."""
    camera = configuration.camera.model_copy(update={"collect_timeout_s": WAIT_S / 4})
    store = StoreSection(folder=str(folder))
    return configuration.model_copy(update={"store": store, "camera": camera})


def _unseen(*_: object) -> None:
    """Show no progress."""


if __name__ == "__main__":
    sys.exit(main())
