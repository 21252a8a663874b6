"""The emergency stop's own port: a listener and threads that nothing else can fill."""

from __future__ import annotations

import contextlib
import errno
import logging
import os
import selectors
import socket
import threading
import time
from dataclasses import dataclass, field
from queue import SimpleQueue
from typing import Protocol

import h11
from starlette.responses import Response

from rigctl.errors import RigError
from rigctl.rig.status import RigStatus
from rigctl.service.guards.auth import ESTOP_PATH
from rigctl.service.guards.origins import OwnOrigins
from rigctl.service.guards.requests import loads
from rigctl.service.models import ReleaseOrder, RigView
from rigctl.service.problems import answer, from_error, unforeseen

_log = logging.getLogger(__name__)

MOST_CONNECTIONS = 64
"""Connections held at once; a further one ends the oldest, so that no caller can fill the port."""

REQUEST_WITHIN_S = 2.0
"""A connection whose request has not come within this time is closed, s."""

_PATHS = frozenset({"/", ESTOP_PATH})
_WHAT_THIS_IS = "POST here stops the rig; nothing else is answered on this port.\n"


class Stoppable(Protocol):
    """Methods of a rig that this port uses; as `rigctl.rig.machine.Rig`."""

    def estop(self, actor: str, reason: str) -> None:
        """Cut the power and latch."""

    def status(self) -> RigStatus:
        """Return the status of the rig."""


@dataclass(slots=True, eq=False)
class _Connection:
    """One caller: what it sent so far, and until when it may go on."""

    link: socket.socket
    peer: str
    until: float
    http: h11.Connection = field(default_factory=lambda: h11.Connection(h11.SERVER))
    request: h11.Request | None = None
    body: bytes = b""


class StopPort:
    """Answers `POST /api/v1/rig/estop`, or `POST /`, on a port of its own.

    One thread reads requests, another stops the rig; callers that come while a stop is under way
    are answered by the next one, together. It needs no key, as the stop of the service.

    Parameters
    ----------
    listening
        The listening socket; closed by `close`.
    rig
        What is stopped.
    origins
        Whose requests are refused.
    """

    def __init__(self, listening: socket.socket, rig: Stoppable, origins: OwnOrigins) -> None:
        self._listening, self._rig, self._origins = listening, rig, origins
        # Given up for a caller when the process has no other descriptor left.
        self._reserve: int | None = os.open(os.devnull, os.O_RDONLY)
        self._wake, self._woken = socket.socketpair()
        self._connections: list[_Connection] = []
        self._orders: SimpleQueue[tuple[_Connection, str] | None] = SimpleQueue()
        self._selector = selectors.DefaultSelector()
        listening.setblocking(False)
        self._selector.register(listening, selectors.EVENT_READ)
        self._selector.register(self._woken, selectors.EVENT_READ)
        self._threads = [
            threading.Thread(target=self._read, name="stop-port", daemon=True),
            threading.Thread(target=self._act, name="stop-port-acts", daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    def close(self) -> None:
        """End both threads once the stops under way are answered, and let the port go."""
        self._wake.close()
        self._orders.put(None)
        for thread in self._threads:
            thread.join(REQUEST_WITHIN_S)

    def _read(self) -> None:
        with self._selector, self._listening, self._woken:
            while True:
                for key, _ in self._selector.select(self._longest_wait_s()):
                    if key.fileobj is self._woken:
                        return
                    if key.fileobj is self._listening:
                        self._accept()
                    else:
                        self._receive(key.data)
                self._end_waits()

    def _longest_wait_s(self) -> float | None:
        if not self._connections:
            return None
        return max(0.0, min(c.until for c in self._connections) - time.monotonic())

    def _accept(self) -> None:
        if len(self._connections) >= MOST_CONNECTIONS:
            self._leave(self._connections[0])
        try:
            link, peer = self._accept_with_reserve()
        except OSError as error:
            _log.warning("a caller of the stop's port was not accepted: %s", error)
            return
        link.setblocking(False)
        until = time.monotonic() + REQUEST_WITHIN_S
        connection = _Connection(link, str(peer[0]), until)
        self._connections.append(connection)
        self._selector.register(link, selectors.EVENT_READ, connection)

    def _accept_with_reserve(self) -> tuple[socket.socket, tuple[object, ...]]:
        with contextlib.suppress(OSError):
            if self._reserve is None:
                self._reserve = os.open(os.devnull, os.O_RDONLY)
        try:
            return self._listening.accept()
        except OSError as error:
            if error.errno not in {errno.EMFILE, errno.ENFILE} or self._reserve is None:
                raise
            os.close(self._reserve)
            self._reserve = None
            return self._listening.accept()

    def _leave(self, connection: _Connection) -> None:
        self._release(connection)
        connection.link.close()

    def _release(self, connection: _Connection) -> None:
        """Read no more from a connection, and keep it open."""
        self._connections.remove(connection)
        self._selector.unregister(connection.link)

    def _receive(self, connection: _Connection) -> None:
        if connection not in self._connections:
            return
        try:
            data = connection.link.recv(LONGEST_REASON)
            connection.http.receive_data(data)
            self._take(connection)
        except (OSError, h11.ProtocolError):
            if connection in self._connections:
                self._leave(connection)
            return
        if not data and connection in self._connections:
            self._leave(connection)

    def _take(self, connection: _Connection) -> None:
        while (event := connection.http.next_event()) is not h11.NEED_DATA:
            if isinstance(event, h11.Request):
                connection.request = event
                connection.until = time.monotonic() + REASON_WAIT_S
            elif isinstance(event, h11.Data):
                connection.body += bytes(event.data)
            if isinstance(event, h11.EndOfMessage) or len(connection.body) > LONGEST_REASON:
                self._decide(connection)
                return
            if isinstance(event, h11.ConnectionClosed):
                return

    def _end_waits(self) -> None:
        now = time.monotonic()
        for connection in [c for c in self._connections if c.until <= now]:
            if connection.request is None:
                self._leave(connection)
            else:
                self._decide(connection)

    def _decide(self, connection: _Connection) -> None:
        request = connection.request
        if request is None:
            self._leave(connection)
            return
        self._release(connection)
        headers = {name.decode("latin-1"): text.decode("latin-1") for name, text in request.headers}
        refusal = self._origins.refusal(headers)
        if refusal is not None:
            _reply(connection, answer(refusal))
        elif request.method == b"POST" and request.target.decode("latin-1") in _PATHS:
            self._orders.put((connection, reason_of(connection.body)))
        else:
            status = 200 if request.method == b"GET" else 405
            _reply(connection, Response(_WHAT_THIS_IS, status, media_type="text/plain"))

    def _act(self) -> None:
        while (first := self._orders.get()) is not None:
            together = [first]
            while not self._orders.empty():
                if (order := self._orders.get()) is None:
                    self._orders.put(None)
                    break
                together.append(order)
            connection, reason = first
            response = self._stopped(f"no key at {connection.peer}", reason)
            for caller, _ in together:
                _reply(caller, response)

    def _stopped(self, actor: str, reason: str) -> Response:
        try:
            self._rig.estop(actor, reason)
            state = RigView.of(self._rig.status()).model_dump_json()
        except RigError as error:
            return answer(from_error(error))
        except Exception as error:  # noqa: BLE001 - the port must outlive any failure
            _log.exception("the stop failed")
            return answer(unforeseen(error, todo="switch the actuators off by hand"))
        return Response(state, media_type="application/json")


def _reply(connection: _Connection, response: Response) -> None:
    """Send an answer and end the connection; who has gone meanwhile gets none."""
    headers = [*response.raw_headers, (b"connection", b"close")]
    pieces = (
        h11.Response(status_code=response.status_code, headers=headers),
        h11.Data(data=bytes(response.body)),
        h11.EndOfMessage(),
    )
    with contextlib.suppress(OSError, h11.ProtocolError), connection.link:
        connection.link.settimeout(REQUEST_WITHIN_S)
        connection.link.sendall(b"".join(connection.http.send(piece) or b"" for piece in pieces))


REASON_WAIT_S = 0.02
"""A stop waits this long for the reason in its body, and no longer, s."""

LONGEST_REASON = 16_384
"""Bytes of a body that are read for a reason."""

NO_REASON = "emergency stop by REST"


def reason_of(body: bytes) -> str:
    """Return the reason that a body states, or `NO_REASON` where it states none."""
    try:
        return ReleaseOrder.model_validate(loads(body)).reason
    except (ValueError, RecursionError):
        return NO_REASON
