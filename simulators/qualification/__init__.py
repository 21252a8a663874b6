"""Apparatus with a known truth, filmed by the simulated camera: stage, drop, disk and shots.

They stand in for the accuracy runs of the thesis: sections 3.3 (Z), 4.2, 4.4 (stage) and 6.
"""

from simulators.qualification.disk import TurningDisk, turning_disk
from simulators.qualification.drop import FilmedDrop, filmed_drop
from simulators.qualification.shots import FilmedShot, filmed_shot
from simulators.qualification.stage import StageRun, stage_run

__all__ = [
    "FilmedDrop",
    "FilmedShot",
    "StageRun",
    "TurningDisk",
    "filmed_drop",
    "filmed_shot",
    "stage_run",
    "turning_disk",
]
