"""Commands run in the process of the tests, which has loaded what they need.

That `rigctl` starts as a process of its own, and how fast, is for `unit/cli/test_command_line.py`.
"""

from __future__ import annotations

import io
import os
import sys
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

from rigctl import cli


@dataclass(frozen=True, slots=True)
class Invoked:
    """What a command left: its exit status, and what it printed."""

    returncode: int
    stdout: str
    stderr: str


def rigctl(
    *arguments: object, folder: Path = Path(), key: str | None = None, typed: str = ""
) -> Invoked:
    """Run a command as `rigctl` with these arguments does.

    Parameters
    ----------
    folder
        Where it is run.
    key
        Of the service, in the environment; None: as this process has it.
    typed
        What a person types.
    """
    out, err = io.StringIO(), io.StringIO()
    environment = {} if key is None else {"RIGCTL_KEY": key}
    with (
        redirect_stdout(out),
        redirect_stderr(err),
        chdir(folder),
        patch.dict(os.environ, environment),
        patch.object(sys, "stdin", io.StringIO(typed)),
    ):
        code = cli.run([*map(str, arguments)])
    return Invoked(code, out.getvalue(), err.getvalue())
