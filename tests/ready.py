"""A `rigctl` for shells that has the model loaded when it starts: a guide's commands are many.

To load what a command of the model needs takes three seconds, and the command itself often less. A
process that has loaded it makes a copy of itself for each command, which runs in the caller's
folder, with its environment and its files. That `rigctl` starts as a process of its own, and how
fast, is for `unit/cli/test_command_line.py`.
"""

from __future__ import annotations

import atexit
import gc
import io
import json
import os
import pkgutil
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout, suppress
from functools import cache
from importlib import import_module
from pathlib import Path

ROOT = Path(__file__).parents[1]
CALLER = """\
#!{python} -IS
import json, os, signal, socket, sys

door = socket.socket(socket.AF_UNIX)
door.connect({address!r})
wish = json.dumps([os.getcwd(), dict(os.environ), sys.argv[1:]]).encode()
socket.send_fds(door, [len(wish).to_bytes(8, "big")], [0, 1, 2])
door.sendall(wish)
process = int.from_bytes(door.recv(8), "big")
for number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(number, lambda number, _: os.kill(process, number))
code = door.recv(1)
sys.exit(code[0] if code else 1)
"""


@cache
def ready() -> Path:
    """Return a folder with such a `rigctl`, for the first place of PATH; it ends with the tests."""
    stack = ExitStack()
    atexit.register(stack.close)
    return stack.enter_context(_begun())


@contextmanager
def _begun() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="rigctl-ready-") as place:
        address, script = str(Path(place) / "door"), Path(place) / "rigctl"
        script.write_text(CALLER.format(python=sys.executable, address=address), encoding="utf-8")
        script.chmod(0o700)
        with subprocess.Popen(
            [sys.executable, "-m", "tests.ready", address], cwd=ROOT, stdout=subprocess.PIPE
        ) as process:
            assert process.stdout is not None
            try:
                assert process.stdout.readline() == b"ready\n"
                yield Path(place)
            finally:
                process.terminate()


def load() -> None:
    """Load the commands of the model and its compiled functions."""
    from rigctl import cli
    from rigctl.cli import model

    for module in pkgutil.iter_modules(model.__path__, f"{model.__name__}."):
        import_module(module.name)
    with (
        tempfile.TemporaryDirectory() as place,
        redirect_stdout(io.StringIO()),
        redirect_stderr(io.StringIO()),
    ):
        campaign = str(Path(place) / "nylon")
        assert cli.run(["challenge", "new", campaign, "--seed", "4", "--shots", "8"]) == 0
        assert cli.run(["model", "explain", campaign]) == 0
    # A copy has no other thread, and would wait for what one of them holds.
    assert len(os.listdir("/proc/self/task")) == 1


def serve(address: str) -> None:
    """Answer callers until the process is ended."""
    load()
    gc.freeze()
    with socket.socket(socket.AF_UNIX) as door:
        door.bind(address)
        door.listen()
        sys.stdout.write("ready\n")
        sys.stdout.flush()
        while True:
            caller, _ = door.accept()
            if os.fork() == 0:
                door.close()
                answer(caller)
                os._exit(0)
            caller.close()
            # Of commands that have ended nothing stays, and their time counts as this process's.
            with suppress(ChildProcessError):
                while os.waitpid(-1, os.WNOHANG) != (0, 0):
                    pass


def answer(caller: socket.socket) -> None:
    """Run one command for a caller, and say how it ended."""
    length, files, *_ = socket.recv_fds(caller, 8, 3)
    with caller.makefile("rb") as wish:
        folder, environment, arguments = json.loads(wish.read(int.from_bytes(length, "big")))
    process = os.fork()
    if process == 0:
        caller.close()
        for number, file in enumerate(files):
            os.dup2(file, number)
            os.close(file)
        os.chdir(folder)
        os.environ.clear()
        os.environ.update(environment)
        tempfile.tempdir = None
        from rigctl import cli

        sys.exit(cli.run(arguments))
    # The caller may have gone.
    with suppress(OSError):
        caller.sendall(process.to_bytes(8, "big"))
    for file in files:
        os.close(file)
    code = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
    with suppress(OSError):
        caller.sendall(bytes([code if code >= 0 else 128 - code]))


if __name__ == "__main__":
    serve(sys.argv[1])
