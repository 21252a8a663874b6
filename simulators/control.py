"""A control socket for a laboratory in a process of its own: faults and state as JSON lines."""

from __future__ import annotations

import contextlib
import json
import socketserver
import threading
from collections.abc import Iterator
from pathlib import Path

from simulators.laboratory import Laboratory

LONGEST_LINE = 64 * 1024


def obey(laboratory: Laboratory, line: bytes) -> dict[str, object]:
    """Carry out one request and return its answer.

    Requests are `{"fault": {"device": ..., "kind": ..., ...}}`, `{"clear": true}`,
    `{"state": true}`, `{"contact": true or false}`, which closes or opens the recorder's
    remote trigger by hand, and `{"switch": true or false}`, which does so with the switch in the
    actuators' supply. Answers are `{"ok": true}` with the state where it was asked for, or
    `{"error": "what is wrong"}`.
    """
    try:
        match json.loads(line):
            case {"fault": dict(options), **rest} if not rest:
                laboratory.fault(**options)
            case {"clear": True, **rest} if not rest:
                laboratory.clear_faults()
            case {"state": True, **rest} if not rest:
                return {"ok": True, "state": laboratory.state()}
            case {"contact": bool(closed), **rest} if not rest:
                laboratory.move_contact(closed)
            case {"switch": bool(closed), **rest} if not rest:
                laboratory.move_switch(closed)
            case _:
                return {"error": "a request is one of fault, clear, state, contact, switch"}
    except (TypeError, ValueError) as error:
        return {"error": str(error)}
    return {"ok": True}


@contextlib.contextmanager
def control_socket(laboratory: Laboratory, path: Path) -> Iterator[None]:
    """Serve requests on a Unix socket for as long as the context lasts."""

    class Handler(socketserver.StreamRequestHandler):
        def handle(self) -> None:
            while line := self.rfile.readline(LONGEST_LINE):
                self.wfile.write(json.dumps(obey(laboratory, line)).encode() + b"\n")

    path.unlink(missing_ok=True)
    with socketserver.ThreadingUnixStreamServer(str(path), Handler) as server:
        # A client that stays connected must not hold up the end of the process.
        server.daemon_threads, server.block_on_close = True, False
        thread = threading.Thread(target=server.serve_forever, args=(0.1,), name="control")
        thread.start()
        try:
            yield
        finally:
            server.shutdown()
            thread.join()
            path.unlink(missing_ok=True)
