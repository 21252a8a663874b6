"""All noise that frames or numbers share: what whitening by their sigmas alone leaves out."""

from __future__ import annotations

from dataclasses import dataclass

from analysis.arrays import Floats
from analysis.model.fitting.jitter import Jitter, by_frame, by_kind
from analysis.model.fitting.slow_errors.whitening import Slow


@dataclass(frozen=True, slots=True, eq=False)
class SharedNoise:
    """Slow errors of the flights, then jitter of the frames' times; either may be absent."""

    slow: Slow | None
    jitter: Jitter | None

    def whiten(self, columns: Floats) -> Floats:
        """Whiten columns by spheres and kinds (S, 4, 3 F, K); with jitter to (S, 1, 12 F, K)."""
        if self.slow is not None:
            columns = self.slow.whiten(columns)
        return columns if self.jitter is None else self.jitter.whiten(columns)

    def whiten_frames(self, columns: Floats) -> Floats:
        """Whiten columns by frames, (S, 12 F, K)."""
        if self.slow is not None:
            columns = by_frame(self.slow.whiten(by_kind(columns)))
        return columns if self.jitter is None else self.jitter.whiten_frames(columns)

    def weigh(self, columns: Floats) -> Floats:
        """Return the transpose of `whiten_frames` times columns (S, 12 F, K)."""
        if self.jitter is not None:
            columns = self.jitter.whiten_frames(columns)
        return columns if self.slow is None else by_frame(self.slow.whiten(by_kind(columns)))
