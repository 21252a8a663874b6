"""Commands run in the process of the tests, which has loaded what they need.

That `rigctl` starts as a process of its own, and how fast, is for `unit/cli/test_command_line.py`.
"""

from __future__ import annotations

import io
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass

from rigctl import cli


@dataclass(frozen=True, slots=True)
class Invoked:
    """What a command left: its exit status, and what it printed."""

    returncode: int
    stdout: str
    stderr: str


def rigctl(*arguments: object) -> Invoked:
    """Run a command as `rigctl` with these arguments does."""
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        code = cli.run([*map(str, arguments)])
    return Invoked(code, out.getvalue(), err.getvalue())
