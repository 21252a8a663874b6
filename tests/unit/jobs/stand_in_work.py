"""What the processes of jobs call in these tests."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path

from rigctl.errors import AnalysisInputError

Say = Callable[[str, float | None], None]


def answers(asked: dict[str, object], say: Say) -> dict[str, object]:
    say("half way", 0.5)
    return {"asked": asked, "process": os.getpid()}


def conditions(asked: dict[str, object], say: Say) -> dict[str, object]:
    return {"nice": os.nice(0), "threads": os.environ["OPENBLAS_NUM_THREADS"]}


def refuses(asked: dict[str, object], say: Say) -> dict[str, object]:
    raise AnalysisInputError("holds no poses", part="result-0001.json", todo="analyse it again")


def breaks(asked: dict[str, object], say: Say) -> dict[str, object]:
    raise ValueError("a bug")


def not_finite(asked: dict[str, object], say: Say) -> dict[str, object]:
    return {"e": float("nan")}


def crashes(asked: dict[str, object], say: Say) -> dict[str, object]:
    os.kill(os.getpid(), signal.SIGSEGV)
    return {}


def leaves(asked: dict[str, object], say: Say) -> dict[str, object]:
    sys.stdout.flush()
    os._exit(3)


def never_ends(asked: dict[str, object], say: Say) -> dict[str, object]:
    say(str(os.getpid()), None)
    threading.Event().wait()
    return {}


def surroundings(asked: dict[str, str], say: Say) -> dict[str, object]:
    """Return what a process finds around itself."""
    descriptors = Path("/proc/self/fd")
    try:
        socket.create_connection(("127.0.0.1", int(asked["port"])), timeout=5.0).close()
        network = "open"
    except OSError as error:
        network = error.strerror or str(error)
    read = {}
    for name, path in (("here", asked["secret"]), ("daemon", f"/proc/{os.getppid()}/environ")):
        try:
            read[name] = Path(path).read_text()
        except OSError as error:
            read[name] = type(error).__name__
    child = subprocess.run(["cat", asked["secret"]], capture_output=True, text=True, check=False)
    bared = subprocess.run(["umount", asked["secret"]], capture_output=True, check=False)
    return {
        "environment": Path("/proc/self/environ").read_text() + " ".join(os.environ),
        "descriptors": [os.readlink(fd) for fd in descriptors.iterdir() if fd.exists()],
        "network": network,
        "read": read,
        "child": child.stdout,
        "bared": bared.returncode == 0,
    }


def packs_an_object(asked: dict[str, object], say: Say) -> dict[str, object]:
    """Send what the daemon would unpack into an object, were it to unpack objects."""
    connection = Connection(int(sys.argv[1]), readable=False)
    connection.send(Harm(str(asked["harm"])))
    threading.Event().wait()
    return {}


class Harm:
    """Makes a file when it is unpacked."""

    def __init__(self, path: str) -> None:
        self.path = path

    def __reduce__(self) -> tuple[object, tuple[str]]:
        return os.mkdir, (self.path,)
