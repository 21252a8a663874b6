"""The process of one job: python -P -m rigctl.jobs.worker DESCRIPTOR, its order on standard input.

Standard input stays open for as long as the daemon lives; when it closes, the process ends itself.
"""

from __future__ import annotations

import importlib
import json
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from rigctl.errors import RigError
from rigctl.jobs.enclosure import enclose

Json = dict[str, Any]
Say = Callable[[str, float | None], None]


def main() -> None:
    """Enclose the process, do the work, and tell the daemon what came of it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    descriptor = int(sys.argv[1])
    # Programs that the work starts are not to hold the daemon's pipe.
    os.set_inheritable(descriptor, False)
    connection = Connection(descriptor, readable=False)
    order: Json = json.loads(sys.stdin.readline())
    # Before anything else is loaded: libraries start threads, and then the kernel refuses.
    enclosure = enclose([Path(path) for path in order["hidden"]], network=order["network"])
    _tell(connection, "enclosed", enclosure)
    threading.Thread(target=_end_with_the_daemon, name="end with the daemon", daemon=True).start()
    sys.path[:] = order["path"]
    _tell(connection, *_answer(connection, order["function"], order["arguments"]))


def _answer(connection: Connection, function: str, arguments: Json) -> tuple[str | None, ...]:
    def say(text: str, share: float | None) -> None:
        _tell(connection, "say", text, share)

    try:
        module, _, name = function.partition(":")
        call: Callable[[Json, Say], Json] = getattr(importlib.import_module(module), name)
        return "done", json.dumps(call(arguments, say), allow_nan=False)
    except RigError as error:
        return "failed", error.sentence(), error.code, ""
    except Exception as error:  # noqa: BLE001 - whatever breaks is told, not lost
        return "failed", f"{type(error).__name__}: {error}", None, traceback.format_exc()


def _tell(connection: Connection, *message: object) -> None:
    """Send JSON: what a job says is never unpacked into objects by the daemon."""
    connection.send_bytes(json.dumps(message).encode())


def _end_with_the_daemon() -> None:
    """End this process when the daemon dies, however that dies."""
    sys.stdin.read()
    os._exit(1)


if __name__ == "__main__":
    main()
