"""`python -m simulators FOLDER`: a laboratory in a process of its own.

Prints one JSON line with the paths of its ports when it is ready, and ends on SIGTERM or SIGINT.
The recorder's contact is reached in the same process only; the control socket moves it instead.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import signal
import sys
from pathlib import Path

from simulators.control import control_socket
from simulators.laboratory import REMOTE_TRIGGER, ROLES, open_laboratory

_ENDS = (signal.SIGTERM, signal.SIGINT)


def main(arguments: list[str] | None = None) -> int:
    """Run a laboratory until a signal ends it; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m simulators", description=__doc__)
    parser.add_argument("folder", type=Path, help="gets the ports, control.sock, capture, truth")
    parser.add_argument("--seed", type=int, default=1, help="of every random number in the world")
    parser.add_argument(
        "--watch-contact", action="store_true", help="the trigger box's watch cuts the power too"
    )
    options = parser.parse_args(arguments)
    # Before any thread starts, so that every thread leaves these signals to `sigwait`.
    signal.pthread_sigmask(signal.SIG_BLOCK, _ENDS)
    folder = options.folder.absolute()
    try:
        laboratory = open_laboratory(
            folder, {"seed": options.seed, "watch_contact": options.watch_contact}
        )
    except (OSError, ValueError) as error:
        print(error, file=sys.stderr)  # noqa: T201  # a command speaks on its streams
        return 2
    control = folder / "control.sock"
    with contextlib.closing(laboratory), control_socket(laboratory, control):
        paths = {role: laboratory.port(role) for role in ROLES if role != REMOTE_TRIGGER}
        paths |= {"control": str(control), "truth": str(laboratory.truth_folder)}
        print(json.dumps(paths), flush=True)  # noqa: T201  # the line that callers wait for
        signal.sigwait(_ENDS)
    return 0


if __name__ == "__main__":
    sys.exit(main())
