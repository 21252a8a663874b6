"""What the rig asks of a camera during a shot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from rigctl.cameras.frames import FrameSequence


@dataclass(frozen=True, slots=True)
class RecordingConfirmation:
    """Proof that frames are being recorded: who said so, when (monotonic s), and what was seen."""

    by: str
    at: float
    evidence: str


class Capture(Protocol):
    """One shot's recording, from confirmed start to frames in memory.

    Nothing fires before `start` has returned.
    """

    @property
    def name(self) -> str:
        """Which camera and which frame source."""

    def check(self) -> None:
        """Ask every part for a sign of life; raise a `RigError` if one gives none."""

    def start(self) -> RecordingConfirmation:
        """Start recording and return once it is confirmed.

        Raises
        ------
        RecordingNotConfirmedError
            No confirmation came within the configured time.
        """

    def mark(self, late_s: float = 0.0) -> None:
        """Note the moment of firing in the recording, `late_s` seconds after it has passed."""

    def collect(self) -> FrameSequence:
        """Stop recording and bring the frames about the mark.

        Raises
        ------
        FramesError
            No frames came in time, or they are not what was configured.
        """

    def stop(self) -> None:
        """Stop recording; harmless when nothing records."""

    def close(self) -> None:
        """Release the devices. Safe to call twice."""
