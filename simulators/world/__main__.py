"""Write an exchange folder of rendered shots: `python -m simulators.world OUT --shots 8`."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from simulators.world.exchange import write_campaign


def main() -> None:
    """Read the command line and write the folder."""
    parser = argparse.ArgumentParser(prog="python -m simulators.world", description=__doc__)
    parser.add_argument("folder", type=Path, help="exchange folder to write")
    parser.add_argument("--shots", type=int, default=8, help="number of shots (default 8)")
    parser.add_argument("--seed", type=int, default=3, help="of markers, scatter and noise")
    parser.add_argument("--frames", type=int, default=24, help="frames a shot (default 24)")
    parser.add_argument(
        "--frame-rate-hz", type=float, default=1000.0, help="frames a second (default 1000)"
    )
    parser.add_argument(
        "--pressures-kpa", type=float, nargs="+", help="one a shot; default 25 to 95"
    )
    parser.add_argument("--offsets-mm", type=float, nargs="+", help="one a shot; default 2 to 20")
    given = parser.parse_args()
    pressures = given.pressures_kpa or np.linspace(25.0, 95.0, given.shots).tolist()
    offsets = given.offsets_mm or np.linspace(2.0, 20.0, given.shots).tolist()
    if len(pressures) != len(offsets):
        parser.error(
            f"{len(pressures)} pressures and {len(offsets)} offsets: give one of each a shot"
        )
    write_campaign(
        given.folder,
        pressures,
        offsets,
        given.seed,
        frame_rate_hz=given.frame_rate_hz,
        frames=given.frames,
    )


if __name__ == "__main__":
    main()
