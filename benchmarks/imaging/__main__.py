"""Run sections of the measurement: python -m benchmarks.imaging centres --images 1000."""

from __future__ import annotations

import argparse
import os

# Set before any library starts threads of its own: speed is that of one core.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import cv2

from benchmarks.imaging import centres, pairs, radius, speed


def main() -> None:
    parser = argparse.ArgumentParser(prog="benchmarks.imaging", description=__doc__)
    parser.add_argument("section", choices=["centres", "radius", "pairs", "speed", "large", "all"])
    parser.add_argument("--images", type=int, default=1000, help="for each case of centres")
    parser.add_argument("--pairs", type=int, default=500, help="at 6 and up to 30 degrees, each")
    parser.add_argument("--seed", type=int, default=1)
    wanted = parser.parse_args()
    cv2.setNumThreads(1)
    if wanted.section in {"centres", "all"}:
        centres.run(wanted.images, wanted.seed)
    if wanted.section in {"radius", "all"}:
        radius.run(wanted.seed)
    if wanted.section in {"pairs", "all"}:
        pairs.run(wanted.pairs, wanted.seed)
    if wanted.section in {"speed", "all"}:
        speed.run(wanted.seed)
    if wanted.section in {"large", "all"}:
        speed.large(wanted.seed)


if __name__ == "__main__":
    main()
