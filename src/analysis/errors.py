"""Why a shot, or a folder, cannot be analysed."""

from __future__ import annotations

from collections.abc import Sequence


class ShotRefusedError(Exception):
    """A shot that cannot be analysed: which step failed, in which frame, and why.

    Attributes
    ----------
    step
        The step's name: frames, outlines, assignment, markers, rotation, motion, contact.
    frame
        Index of the frame, counted from 0; None where the whole shot is meant.
    reason
        What was found and what was needed.
    discs
        Row, column and radius of the discs that were found in the frame, pixels.
    """

    def __init__(
        self,
        step: str,
        reason: str,
        frame: int | None = None,
        discs: Sequence[tuple[float, float, float]] = (),
    ) -> None:
        self.step, self.reason, self.frame, self.discs = step, reason, frame, tuple(discs)
        place = step if frame is None else f"{step}, frame {frame}"
        super().__init__(f"{place}: {reason}")


LONGEST_REASON = 1000
"""Characters of a refusal; what a file holds may be quoted in it, however long that is."""


class NoContactError(ShotRefusedError):
    """The frames that show both spheres hold no contact, or too little of one side of it."""


class InputError(Exception):
    """A file or folder that cannot be read: which file, where in it, and why."""

    def __init__(self, path: object, reason: str, line: int | None = None) -> None:
        self.path, self.line, self.reason = str(path), line, shortened(reason)
        place = self.path if line is None else f"{self.path}, line {line}"
        super().__init__(f"{place}: {self.reason}")


def shortened(reason: str) -> str:
    """Return a text as a sentence can hold it: of a long one, both ends and what lies between."""
    if len(reason) <= LONGEST_REASON:
        return reason
    half = LONGEST_REASON // 2
    return f"{reason[:half]} [{len(reason) - 2 * half} characters] {reason[-half:]}"


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, plural where needed: `1 frame`, `5 frames`."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


class LaunchRefusedError(Exception):
    """Settings from which no launch can be fitted or predicted: what was found and needed."""


class ProposalRefusedError(Exception):
    """Shots from which no law can be proposed: what was found, what was needed."""
