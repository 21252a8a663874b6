"""A network between browser and daemon that can be held up and cut."""

from __future__ import annotations

import socket
import threading
from contextlib import suppress
from urllib.parse import urlsplit

CHUNK = 65536


class Wire:
    """Hands every connection on to a daemon; `url` is where the browser finds it.

    Held up, it takes what the daemon sends and hands nothing on. Cut, it drops every connection
    with whatever it holds, and closes each new one.
    """

    def __init__(self, url: str) -> None:
        self._daemon = "127.0.0.1", int(urlsplit(url).port or 0)
        self._ears = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self._ears.getsockname()[1]}"
        self._flows, self._whole = threading.Event(), True
        self._flows.set()
        self._ends: set[socket.socket] = set()
        threading.Thread(target=self._accept, daemon=True).start()

    def hold(self) -> None:
        """Hand nothing on to the browser any more; both sides believe that they are connected."""
        self._flows.clear()

    def cut(self) -> None:
        """Drop every connection and what it holds."""
        self._whole = False
        for end in tuple(self._ends):
            _close(end)
        self._flows.set()

    def mend(self) -> None:
        """Be whole again, for new connections."""
        self._whole = True

    def end(self) -> None:
        """Take no more connections."""
        self.cut()
        _close(self._ears)

    def _accept(self) -> None:
        while True:
            try:
                browser, _ = self._ears.accept()
            except OSError:
                return
            try:
                daemon = socket.create_connection(self._daemon) if self._whole else None
            except OSError:
                daemon = None
            if daemon is None:
                _close(browser)
                continue
            self._ends |= {browser, daemon}
            for ends in ((browser, daemon, False), (daemon, browser, True)):
                threading.Thread(target=self._carry, args=ends, daemon=True).start()

    def _carry(self, source: socket.socket, target: socket.socket, held: bool) -> None:
        with suppress(OSError):
            while data := source.recv(CHUNK):
                if held:
                    self._flows.wait()
                target.sendall(data)
        for end in (source, target):
            self._ends.discard(end)
            _close(end)


def _close(end: socket.socket) -> None:
    with suppress(OSError):
        end.shutdown(socket.SHUT_RDWR)
    end.close()
