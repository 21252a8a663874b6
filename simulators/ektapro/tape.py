"""The tape: what it holds, at which rate, and in which format."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

FULL_FRAME_RATES = (30, 60, 125, 250, 500, 1000)
PICTURES_PER_FRAME = (1, 2, 3, 4, 6)
SENSOR_ROWS = 192

# Whole tapes per second, a + b * rate: the line through 30 s at 1000/s and 16 min at 30/s
# (thesis appendix A), the only two recording times that are given.
_PER_FRAME = (1 / 30 - 1 / 960) / (1000 - 30)
_PER_SECOND = 1 / 960 - 30 * _PER_FRAME
# A picture's instant may fall on the reading instant but for rounding of the clock's float.
_ROUNDING = 1e-6


@dataclass(frozen=True, slots=True)
class RecordingFormat:
    """Full frames a second, and how many pictures share one frame's 192 rows.

    Raises
    ------
    ValueError
        The recorder has no such rate or split.
    """

    full_frames_per_s: int = 1000
    pictures_per_frame: int = 1

    def __post_init__(self) -> None:
        if self.full_frames_per_s not in FULL_FRAME_RATES:
            raise ValueError(f"rate is one of {FULL_FRAME_RATES}")
        if self.pictures_per_frame not in PICTURES_PER_FRAME:
            raise ValueError(f"pictures per frame is one of {PICTURES_PER_FRAME}")

    @property
    def pictures_per_s(self) -> int:
        """Up to 6000 a second."""
        return self.full_frames_per_s * self.pictures_per_frame

    @property
    def rows(self) -> int:
        """Rows of one picture."""
        return SENSOR_ROWS // self.pictures_per_frame

    @property
    def tape_duration_s(self) -> float:
        """How long a whole tape records."""
        return 1 / (_PER_SECOND + _PER_FRAME * self.full_frames_per_s)


@dataclass(slots=True)
class Session:
    """One recording: picture n is taken at `first_s + n / pictures_per_s` of laboratory time.

    Attributes
    ----------
    room
        How many pictures the tape has left for it.
    pictures
        How many it holds; None while it is recorded.
    """

    number: int
    format: RecordingFormat
    first_s: float
    room: int
    pictures: int | None = None
    marks: list[int] = field(default_factory=list)

    def count(self, time_s: float) -> int:
        """Return how many pictures are recorded by a laboratory time in seconds."""
        if self.pictures is not None:
            return self.pictures
        if time_s < self.first_s:
            return 0
        taken = math.floor((time_s - self.first_s) * self.format.pictures_per_s + _ROUNDING) + 1
        return min(taken, self.room)


class Tape:
    """Sessions one behind the other; the tape fills and is emptied only by erasing it all."""

    def __init__(self) -> None:
        self._sessions: list[Session] = []

    @property
    def sessions(self) -> Sequence[Session]:
        """All sessions on the tape, numbered from 1 in the order of recording."""
        return tuple(self._sessions)

    def room(self, recording_format: RecordingFormat, time_s: float) -> int:
        """Return how many pictures of a format still fit at a laboratory time in seconds."""
        used = sum(
            session.count(time_s) / session.format.pictures_per_s / session.format.tape_duration_s
            for session in self._sessions
        )
        whole = recording_format.tape_duration_s * recording_format.pictures_per_s
        return max(0, math.floor(whole * (1 - used) + _ROUNDING))

    def begin(self, recording_format: RecordingFormat, first_s: float) -> Session:
        """Begin a session whose first picture is taken at a laboratory time in seconds."""
        room = self.room(recording_format, first_s)
        session = Session(len(self._sessions) + 1, recording_format, first_s, room)
        self._sessions.append(session)
        return session

    def erase(self) -> None:
        """Lose every session; numbers begin at 1 again."""
        self._sessions.clear()
