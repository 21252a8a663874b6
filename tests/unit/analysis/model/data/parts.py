"""Campaigns in memory handed over in parts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from analysis.model.data.poses import PoseData
from analysis.model.data.stream import PoseStream


def in_parts(data: PoseData, lengths: Sequence[int]) -> Iterator[PoseData]:
    """Yield parts of these lengths, the last length again and again."""
    start, k = 0, 0
    while start < len(data.shots):
        stop = start + lengths[min(k, len(lengths) - 1)]
        yield data.part(slice(start, stop))
        start, k = stop, k + 1


def streamed(data: PoseData, *lengths: int) -> PoseStream:
    return PoseStream.of(in_parts(data, lengths or (128,)))


def gathered(stream: PoseStream, name: str) -> np.ndarray:
    """Return one array of all shots."""
    return np.concatenate([getattr(part, name) for part in stream.parts()])
