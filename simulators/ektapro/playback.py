"""Where playback stands, as a function of time."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Playback:
    """Uniform playback between two pictures, or a standing picture where both are one.

    `since_s` is laboratory time in seconds; `per_s` is pictures a second, positive.
    """

    start: int
    end: int
    since_s: float
    per_s: float

    @classmethod
    def standing(cls, picture: int) -> Playback:
        """Return playback that stands on a picture."""
        return cls(picture, picture, 0.0, 1.0)

    def at(self, time_s: float) -> int:
        """Return the picture on show at a laboratory time in seconds."""
        way = abs(self.end - self.start)
        shown = min(way, int((time_s - self.since_s) * self.per_s))
        return self.start + shown if self.end >= self.start else self.start - shown

    def ended(self, time_s: float) -> bool:
        """Say whether the last picture is reached."""
        return self.at(time_s) == self.end
