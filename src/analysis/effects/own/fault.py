"""What is wrong with an effect that a user wrote, and where."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing that keeps an effect from being used.

    Attributes
    ----------
    path, line
        File, and line counted from 1.
    effect
        Name of the effect; the file's own name while no effect is known.
    what
        One clause without a full stop: what happened.
    todo
        What its author does next.
    """

    path: Path
    line: int
    effect: str
    what: str
    todo: str

    def sentence(self) -> str:
        """Return the fault as one line of text."""
        return f"{self.path}, line {self.line}: {self.effect}: {self.what}; {self.todo}"

    def to_json(self) -> dict[str, Any]:
        """Return the form of the exchange documents."""
        return {
            "path": str(self.path),
            "line": self.line,
            "effect": self.effect,
            "what": self.what,
            "todo": self.todo,
        }


class EffectFault(Exception):  # noqa: N818 - a fault of the user's file, not an error of this program
    """An effect failed while it was in use; `fault` has place and reason."""

    def __init__(self, fault: Fault) -> None:
        self.fault = fault
        # The fault is the only argument, so that the exception crosses process borders whole.
        super().__init__(fault)

    def __str__(self) -> str:
        """Return the fault's sentence."""
        return self.fault.sentence()


def line_in(path: Path, traceback: TracebackType | None) -> int | None:
    """Return the innermost line of a traceback in a file, None without one."""
    line = None
    while traceback is not None:
        if traceback.tb_frame.f_code.co_filename == str(path):
            line = traceback.tb_lineno
        traceback = traceback.tb_next
    return line


def exception_text(error: BaseException) -> str:
    """Return an exception as one clause on one line."""
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
