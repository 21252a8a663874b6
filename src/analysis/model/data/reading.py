"""From the poses of a campaign, a shot at a time, to the parts that are fitted."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.campaign import DESCRIPTION, SHOT_LIST
from analysis.errors import InputError
from analysis.exchange.description import read_description
from analysis.exchange.pose_table import Spheres, each_shot
from analysis.exchange.shot_list import each_shot_row
from analysis.model.data.columns import ShotColumns
from analysis.model.data.gather import (
    GUESSES,
    POSES,
    fired,
    nothing_seen,
    stated_medians,
    stated_poses,
    typical_error,
    usable,
    with_guesses,
)
from analysis.model.data.parts import SHOTS_AT_ONCE, regrouped
from analysis.model.data.plate import LEVEL, Plate
from analysis.model.data.plate_found import plate_of
from analysis.model.data.poses import PoseData
from analysis.model.data.spool import Spool
from analysis.model.data.stream import PoseStream
from analysis.setup import Setup


def stream_poses(campaign: Path) -> tuple[str, PoseStream]:
    """Read the poses of a campaign of any length, whatever later stage there is.

    Parameters
    ----------
    campaign
        The folder, or poses.csv in it. The rows of a shot must follow each other there.

    Returns
    -------
    The campaign's name, and its poses in a temporary file.

    Raises
    ------
    InputError
        A file cannot be read, there is no poses.csv, or no shot has poses.
    OSError
        The temporary folder is full.
    """
    if campaign.is_file() and campaign.name != POSES:
        raise InputError(campaign, f"only {POSES} is read a shot at a time")
    folder = campaign.parent if campaign.is_file() else campaign
    name, setup = read_description(folder / DESCRIPTION)
    if not (folder / POSES).exists():
        reason = f"no such file; have the frames measured first: rigctl analyse {folder} --out"
        raise InputError(folder / POSES, reason)
    columns = ShotColumns(each_shot_row(folder / SHOT_LIST))
    found = (spheres for n, spheres in each_shot(folder / POSES) if n not in columns.excluded)
    read = Reading(plate_of(setup, found))
    for shots in parted(each_shot(folder / POSES)):
        read.add(shots, columns, setup)
    stream = read.finished(columns, setup)
    if len(stream.shots) == 0:
        raise InputError(folder, nothing_seen(setup))
    return name, stream


def parted(shots: Iterable[tuple[int, Spheres]]) -> Iterator[dict[int, Spheres]]:
    """Return so many shots at a time as make a part."""
    left = iter(shots)
    while part := dict(islice(left, SHOTS_AT_ONCE)):
        yield part


@dataclass(slots=True, eq=False)
class Reading:
    """Parts of a campaign as they were stated, until all is known that they share.

    Attributes
    ----------
    plate
        How it lies, where b is one.
    parts
        Errors that are not stated are NaN.
    numbers, fired
        Of the shots of each part, and those that the shot list has for them.
    medians
        Stated errors of positions and of orientations in each shot of each part, m and rad.
    excluded
        Numbers of shots that are not here because a person left them out.
    """

    plate: Plate = LEVEL
    parts: Spool[PoseData] = field(default_factory=lambda: Spool(PoseData))
    numbers: list[NDArray[np.intp]] = field(default_factory=list)
    fired: list[NDArray[np.intp]] = field(default_factory=list)
    medians: tuple[list[Floats], list[Floats]] = field(default_factory=lambda: ([], []))
    excluded: set[int] = field(default_factory=set)

    def add(self, shots: dict[int, Spheres], columns: ShotColumns, setup: Setup) -> None:
        """Add the next shots, without those that a person excluded."""
        self.excluded |= columns.excluded & shots.keys()
        counting = {n: spheres for n, spheres in shots.items() if n not in columns.excluded}
        if not counting:
            return
        part = stated_poses(counting, columns, setup, self.plate)
        self.parts.append(part)
        self.numbers.append(part.shots)
        self.fired.append(fired(part))
        for kept, own in zip(self.medians, stated_medians(part), strict=True):
            kept.append(own)

    def finished(self, columns: ShotColumns, setup: Setup) -> PoseStream:
        """Return the stream of all shots that show both spheres, with what they share."""
        parts, order = self._in_order()
        shots = np.concatenate([np.zeros(0, dtype=np.intp), *self.fired])[order]
        covariates = columns.covariates(shots)
        camera = replace(setup.camera, exposure_s=columns.exposure_s(shots))
        position, rotation = (
            typical_error(np.concatenate([np.zeros(0), *own]), guess)
            for own, guess in zip(self.medians, GUESSES, strict=True)
        )

        def shown() -> Iterator[PoseData]:
            start = 0
            for part in parts:
                own = slice(start, start + part.count)
                start = own.stop
                shared = {name: column[own] for name, column in covariates.items()}
                guessed = with_guesses(part, position, rotation)
                yield usable(
                    replace(guessed, covariates=shared, camera=camera, slow=setup.measurement)
                )

        return replace(PoseStream.of(shown()), excluded=tuple(sorted(self.excluded)))

    def _in_order(self) -> tuple[Iterable[PoseData], NDArray[np.intp]]:
        """Return all parts, their shots in the order of their numbers, and this order."""
        numbers = np.concatenate([np.zeros(0, dtype=np.intp), *self.numbers])
        order = np.argsort(numbers, kind="stable")
        if (np.diff(order) == 1).all():
            return self.parts, order
        single, longest = Spool(PoseData), 0
        for part in self.parts:
            longest = max(longest, part.times_s.shape[1])
            for k in range(part.count):
                single.append(part.part(slice(k, k + 1)))
        shots = (single.item(int(k)).padded(longest) for k in order)
        return regrouped(shots), order
