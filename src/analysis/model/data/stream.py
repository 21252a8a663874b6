"""Poses of a campaign that are read so many shots at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.operator import Body
from analysis.model.data.parts import Kept, regrouped
from analysis.model.data.poses import Frame, PoseData
from analysis.model.data.spool import Spool
from analysis.model.data.tables import ContactTable, Data
from analysis.model.fitting.systematics import Systematic
from analysis.schema.verdict import TornTrack
from analysis.setup import SlowErrors

T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class PoseStream:
    """Parts of a campaign, read anew at each pass, and what is done to them on the way.

    Attributes
    ----------
    stored
        Poses as they were stated; covariates are those of the whole campaign.
    frames
        Of the longest shot: all parts are padded to it.
    stated
        Numbers of the shots in the parts, shape (S,).
    kept
        Mask of the shots that are handed out, shape (S,).
    weight
        By what the sigmas of each shot are divided, shape (S,).
    noise
        By what sigmas of positions and of orientations are multiplied.
    gone
        Frames that are taken out.
    jitter_s
        Standard deviation of each frame's time, s.
    unusable, excluded
        Numbers of shots that are not here: without frames that show both spheres, and left out by
        a person.
    estimated
        Whether some errors were not stated.
    torn
        Shot number, sphere, first and last frame of what was cut of tracks that leave free flight.
    """

    stored: Kept[PoseData]
    frames: int
    stated: NDArray[np.intp]
    kept: NDArray[np.bool_]
    weight: Floats
    noise: tuple[float, float] = (1.0, 1.0)
    gone: tuple[Frame, ...] = ()
    jitter_s: float = 0.0
    unusable: tuple[int, ...] = ()
    excluded: tuple[int, ...] = ()
    estimated: bool = False
    torn: tuple[TornTrack, ...] = ()

    @classmethod
    def of(cls, parts: Iterable[PoseData]) -> PoseStream:
        """Take up parts of a campaign, a few hundred shots each at most, into a temporary file.

        Covariates must be those of the whole campaign. `OSError`: the file cannot be written.
        """
        kept, numbers = Spool(PoseData), []
        unusable, excluded, estimated, frames = list[int](), list[int](), False, 0
        for part in parts:
            unusable += part.unusable
            excluded += part.excluded
            estimated |= part.estimated
            if len(part.shots) > 0:
                frames = max(frames, part.times_s.shape[1])
                kept.append(part)
                numbers.append(part.shots)
        stated = np.concatenate([np.zeros(0, dtype=np.intp), *numbers])
        return cls(
            stored=kept,
            frames=frames,
            stated=stated,
            kept=np.ones(len(stated), dtype=np.bool_),
            weight=np.ones(len(stated)),
            unusable=tuple(sorted(unusable)),
            excluded=tuple(sorted(excluded)),
            estimated=estimated,
        )

    @property
    def shots(self) -> NDArray[np.intp]:
        """Numbers of the shots that are handed out."""
        return self.stated[self.kept]

    @property
    def bodies(self) -> tuple[Body, Body]:
        """Spheres a and b."""
        return self._first.bodies

    @property
    def systematics(self) -> tuple[Systematic, ...]:
        """Return what all shots share and is known beforehand with an error."""
        return self._first.systematics

    @property
    def slow(self) -> SlowErrors:
        """Errors that last, of a typical shot."""
        return self._first.slow

    @property
    def _first(self) -> PoseData:
        return next(iter(self.stored))

    def parts(self) -> Iterator[PoseData]:
        """Hand out so many shots at a time, as the campaign in memory does."""
        return regrouped(self._pieces())

    def keep(self, kind: type[T]) -> Kept[T]:
        """Return where to keep what has a number for each shot: in a temporary file."""
        return Spool(kind)

    def whole(self) -> PoseData:
        """Return the campaign in memory."""
        return PoseData.joined(list(self.parts()))

    def _pieces(self) -> Iterator[PoseData]:
        """Hand out what is left of each stored part in order."""
        start = 0
        for part in self.stored:
            own = slice(start, start + len(part.shots))
            start = own.stop
            if self.kept[own].any():
                yield self._changed(part, own)

    def of_shots(self, chosen: NDArray[np.bool_]) -> PoseStream:
        """Return the stream of some of the shots that are handed out, mask of their length."""
        kept = self.kept.copy()
        kept[kept] = chosen
        return replace(self, kept=kept)

    def held_down(self, weight: Floats) -> PoseStream:
        """Return the stream with the sigmas of each shot handed out divided by a weight."""
        divided = self.weight.copy()
        divided[self.kept] *= weight
        return replace(self, weight=divided)

    def without_frames(self, frames: Iterable[Frame]) -> PoseStream:
        """Return the stream with some more frames taken out."""
        return replace(self, gone=(*self.gone, *frames))

    def with_noise(self, position: float, rotation: float) -> PoseStream:
        """Return the stream with sigmas of positions and of orientations multiplied."""
        return replace(self, noise=(position * self.noise[0], rotation * self.noise[1]))

    def changed(self, change: Callable[[PoseData], PoseData]) -> PoseStream:
        """Return the stream with all its parts changed once, and kept so."""
        stored, torn = Spool(PoseData), list[TornTrack]()
        for part in regrouped(part.padded(self.frames) for part in self.stored):
            other = change(part)
            torn += other.torn
            stored.append(other)
        return replace(self, stored=stored, torn=tuple(dict.fromkeys(torn)))

    def _changed(self, part: PoseData, own: slice) -> PoseData:
        part = part.padded(self.frames)
        if self.noise != (1.0, 1.0):
            part = part.with_noise(*self.noise)
        if (self.weight[own] != 1.0).any():
            part = part.held_down(self.weight[own])
        if self.gone:
            part = part.without_frames(self.gone)
        part = replace(part, jitter_s=self.jitter_s)
        kept = self.kept[own]
        return part if kept.all() else part.of_shots(kept)


CampaignData = PoseData | ContactTable | PoseStream
"""What a fit goes over, so many shots at a time: in memory, or read from a file at each pass."""


def beside(data: CampaignData, kept: Iterable[T]) -> Iterator[tuple[Data, T]]:
    """Go over the parts of a campaign, each with what was kept of it, in order."""
    parts: Iterator[Data] = data.parts()
    return zip(parts, kept, strict=True)


def whole(data: CampaignData) -> Data:
    """Return a campaign in memory."""
    return data.whole() if isinstance(data, PoseStream) else data
