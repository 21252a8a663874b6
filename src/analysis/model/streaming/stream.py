"""Poses of a campaign that are read so many shots at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.model.data.parts import Kept
from analysis.model.data.poses import PoseData
from analysis.model.streaming.spool import Spool

Floats = NDArray[np.float64]
Frame = tuple[int, int]
"""Number of a shot, and the index of one of its frames."""


@dataclass(frozen=True, slots=True, eq=False)
class PoseStream:
    """Parts of a campaign, read anew at each pass, and what is done to them on the way.

    Attributes
    ----------
    parts
        Poses as they were stated; covariates are those of the whole campaign.
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
    """

    parts: Kept[PoseData]
    stated: NDArray[np.intp]
    kept: NDArray[np.bool_]
    weight: Floats
    noise: tuple[float, float] = (1.0, 1.0)
    gone: tuple[Frame, ...] = ()
    jitter_s: float = 0.0
    unusable: tuple[int, ...] = ()
    excluded: tuple[int, ...] = ()
    estimated: bool = False

    @classmethod
    def of(cls, parts: Iterable[PoseData]) -> PoseStream:
        """Take up parts of a campaign, a few hundred shots each at most, into a temporary file.

        Covariates must be those of the whole campaign. `OSError`: the file cannot be written.
        """
        kept, numbers = Spool(PoseData), []
        unusable, excluded, estimated = list[int](), list[int](), False
        for part in parts:
            unusable += part.unusable
            excluded += part.excluded
            estimated |= part.estimated
            if len(part.shots) > 0:
                kept.append(part)
                numbers.append(part.shots)
        stated = np.concatenate([np.zeros(0, dtype=np.intp), *numbers])
        return cls(
            parts=kept,
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

    def __iter__(self) -> Iterator[PoseData]:
        """Hand out the parts in order, none without a shot."""
        start = 0
        for part in self.parts:
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

    def without(self, frames: Iterable[Frame]) -> PoseStream:
        """Return the stream with some more frames taken out."""
        return replace(self, gone=(*self.gone, *frames))

    def scaled(self, position: float, rotation: float) -> PoseStream:
        """Return the stream with sigmas of positions and of orientations multiplied."""
        return replace(self, noise=(position * self.noise[0], rotation * self.noise[1]))

    def spooled(self, change: Callable[[PoseData], PoseData]) -> PoseStream:
        """Return the stream with all its parts changed once, and kept so."""
        parts = Spool(PoseData)
        for part in self.parts:
            parts.append(change(part))
        return replace(self, parts=parts)

    def _changed(self, part: PoseData, own: slice) -> PoseData:
        weight = self.weight[own]
        position, rotation = self.noise
        part = part.with_sigmas(
            part.position_sigma * (position / weight)[:, None, None, None],
            part.rotation_sigma * (rotation / weight)[:, None, None],
        )
        if self.gone:
            rows = {int(number): s for s, number in enumerate(part.shots)}
            mask = np.zeros(part.times_s.shape, dtype=np.bool_)
            for number, frame in self.gone:
                if number in rows:
                    mask[rows[number], frame] = True
            part = part.without(mask)
        part = replace(part, jitter_s=self.jitter_s)
        kept = self.kept[own]
        return part if kept.all() else part.of_shots(kept)
