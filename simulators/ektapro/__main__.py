"""Play frames back as the recorder does, and digitise that: `python -m simulators.ektapro`."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

import numpy as np
import tifffile
from numpy.typing import NDArray

from simulators.ektapro.grabber import LINES, Grabber, Wrong
from simulators.ektapro.processor import REPLAY_PER_S


def main(arguments: list[str] | None = None) -> int:
    """Write the film, and print the true number on both fields of each of its frames."""
    parser = argparse.ArgumentParser(prog="python -m simulators.ektapro", description=__doc__)
    parser.add_argument("frames", type=Path, help="TIFF or NPY of recorded pictures")
    parser.add_argument("film", type=Path, help="NPY of the grabber's frames")
    parser.add_argument("--standard", choices=sorted(LINES), default="pal", help="of television")
    parser.add_argument("--phase", type=float, default=0.3, help="pictures shown at the start")
    parser.add_argument("--repeat", type=int, nargs="*", default=[], help="fields given again")
    parser.add_argument("--skip", type=int, nargs="*", default=[], help="frames left out")
    given = parser.parse_args(arguments)
    read = np.load if given.frames.suffix == ".npy" else tifffile.imread
    pictures: NDArray[np.uint8] = read(given.frames)
    last = len(pictures) - 1

    def shown(time_s: float) -> tuple[int, NDArray[np.uint8]]:
        number = min(last, int(time_s * REPLAY_PER_S + given.phase))
        return number, pictures[number]

    grabber = Grabber(shown, given.standard, Wrong(frozenset(given.repeat), frozenset(given.skip)))
    count = int((last + 1 - given.phase) / REPLAY_PER_S * grabber.frames_per_s)
    frames = grabber.frames(count)
    np.save(given.film, np.stack([pixels for _, _, pixels in frames]))
    print(json.dumps({"numbers": [numbers for _, numbers, _ in frames]}))  # noqa: T201
    return 0


if __name__ == "__main__":
    sys.exit(main())
