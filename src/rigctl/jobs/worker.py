"""A worker's process: python -P -m rigctl.jobs.worker DESCRIPTOR, ordered on standard input.

Lines of JSON: under what it runs and what it loads at once, then each order, perhaps much later.

Standard input stays open for as long as the daemon lives; when it closes, the process ends itself.
"""

from __future__ import annotations

import ctypes
import importlib
import json
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path
from queue import SimpleQueue

from rigctl.documents import Json
from rigctl.errors import RigError
from rigctl.progress import Progress

_NEWNS, _NEWUSER, _NEWNET = 0x00020000, 0x10000000, 0x40000000
_BIND, _RECURSIVE, _PRIVATE = 0x1000, 0x4000, 0x40000
_CAPBSET_DROP, _NO_NEW_PRIVS = 24, 38
_LAST_CAPABILITY = 63
_CAPABILITY_VERSION = 0x20080522

ENCLOSED = "no network, no key, no look into other processes"
ON_NETWORK = "no key, no look into other processes; the network is open for the catalogue's server"
NETWORK_ALONE = "no network; {path} could not be hidden ({why})"
OPEN = "network and key file are open to it: the kernel gives no namespaces ({why})"


def enclose(hidden: Sequence[Path], *, network: bool) -> str:
    """Keep this process, and all that it starts, from these files and perhaps the network.

    It must have one thread still.

    Returns
    -------
    What it is kept from, in words for the job's record; also where the kernel refuses.
    """
    user, group = os.getuid(), os.getgid()
    try:
        _call("unshare", _NEWUSER | _NEWNS | (0 if network else _NEWNET))
    except OSError as error:
        return OPEN.format(why=error.strerror)
    try:
        _map("setgroups", "deny")
        _map("uid_map", f"{user} {user} 1")
        _map("gid_map", f"{group} {group} 1")
        _call("mount", None, b"/", None, _RECURSIVE | _PRIVATE, None)
        for path in hidden:
            if path.exists():
                _call("mount", b"/dev/null", os.fsencode(path), None, _BIND, None)
    except OSError as error:
        return NETWORK_ALONE.format(path=", ".join(map(str, hidden)), why=error.strerror)
    finally:
        _give_up_capabilities()
    return ON_NETWORK if network else ENCLOSED


def _map(name: str, text: str) -> None:
    Path("/proc/self", name).write_text(text, encoding="ascii")


def _give_up_capabilities() -> None:
    """Give up what a new user namespace gives; what is mounted stays."""
    for capability in range(_LAST_CAPABILITY + 1):
        try:
            _call("prctl", _CAPBSET_DROP, capability, 0, 0, 0)
        except OSError:
            break
    _call("prctl", _NO_NEW_PRIVS, 1, 0, 0, 0)
    header = (ctypes.c_uint32 * 2)(_CAPABILITY_VERSION, 0)
    _call("capset", header, (ctypes.c_uint32 * 6)())


def _call(name: str, *arguments: object) -> None:
    library = ctypes.CDLL(None, use_errno=True)
    if getattr(library, name)(*arguments) != 0:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))


def main() -> None:
    """Enclose the process, do each order, and send the daemon what came of it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    descriptor = int(sys.argv[1])
    # Programs that the work starts are not to hold the daemon's pipe.
    os.set_inheritable(descriptor, False)
    connection = Connection(descriptor, readable=False)
    under: Json = json.loads(sys.stdin.readline())
    # Before anything else is loaded: libraries start threads, and then the kernel refuses.
    enclosure = enclose([Path(path) for path in under["hidden"]], network=under["network"])
    _tell(connection, "enclosed", enclosure)
    sys.path[:] = under["path"]
    orders = SimpleQueue[str]()
    threading.Thread(target=_hear, args=(orders,), name="orders", daemon=True).start()
    for module in under["loads"]:
        _load(module)

    def progress(text: str, share: float | None) -> None:
        _tell(connection, "progress", text, share)

    while True:
        order: Json = json.loads(orders.get())
        _tell(connection, *_answer(order["function"], order["arguments"], progress))


def _load(name: str) -> None:
    """Load what an order will need; one that cannot be loaded is the order's failure.

    A module that has a function `prepare` says by it what else can be made ready.
    """
    with suppress(Exception):
        module = importlib.import_module(name)
        if (prepare := getattr(module, "prepare", None)) is not None:
            prepare()


def _answer(function: str, arguments: Json, progress: Progress) -> tuple[str | None, ...]:
    try:
        module, _, name = function.partition(":")
        call: Callable[[Json, Progress], Json] = getattr(importlib.import_module(module), name)
        return "done", json.dumps(call(arguments, progress), allow_nan=False)
    except RigError as error:
        return "failed", error.sentence(), error.code, ""
    except Exception as error:  # noqa: BLE001 - sent to the daemon, not lost
        return "failed", f"{type(error).__name__}: {error}", None, traceback.format_exc()


def _tell(connection: Connection, *message: object) -> None:
    """Send JSON: what a job says is never unpacked into objects by the daemon."""
    connection.send_bytes(json.dumps(message).encode())


def _hear(orders: SimpleQueue[str]) -> None:
    """Take orders, and end this process when the daemon dies, however that dies."""
    for line in iter(sys.stdin.readline, ""):
        orders.put(line)
    os._exit(1)


if __name__ == "__main__":
    main()
