"""The camera's HTTP service, on a port of its own."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import parse_qs, urlsplit

from simulators.chronos.camera import STORAGE, Camera, CameraFault

SILENCE_S = 30.0


class CameraServer:
    """Serves a camera on loopback until it is closed."""

    def __init__(self, camera: Camera) -> None:
        self._ending = threading.Event()
        ending = self._ending

        class Handler(_Handler):
            pass

        Handler.camera, Handler.ending = camera, ending
        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        self._server.block_on_close = False
        self._thread = threading.Thread(
            target=self._server.serve_forever, args=(0.05,), name="chronos", daemon=True
        )
        self._thread.start()

    @property
    def url(self) -> str:
        """Where it is reached."""
        return f"http://127.0.0.1:{self._server.server_address[1]}"

    def close(self) -> None:
        """Take it off the network. Safe to call twice."""
        self._ending.set()
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


class _Handler(BaseHTTPRequestHandler):
    camera: Camera
    ending: threading.Event

    def do_GET(self) -> None:
        """Answer for parameters and files."""
        parts = urlsplit(self.path)
        if parts.path.startswith("/control/p/"):
            name, parameters = parts.path.rpartition("/")[2], self.camera.parameters()
            known = {name: parameters[name]} if name in parameters else dict[str, object]()
            self._answer(known)
        elif parts.path == "/cgi-bin/listFiles" and parts.query == STORAGE:
            self._answer(self.camera.listed())
        elif parts.path == "/cgi-bin/pleaseGiveMeAFile":
            asked = parse_qs(parts.query).get("fileName", [""])[0]
            data = self.camera.file(asked)
            self._send(200 if data is not None else 404, data or b"", "image/tiff")
        else:
            self._send(404, b"no such page", "text/plain")

    def do_POST(self) -> None:
        """Obey an order."""
        body = self.rfile.read(int(self.headers.get("Content-Length", 0))) or b"{}"
        order = dict(json.loads(body))
        camera = self.camera
        orders: dict[str, Callable[[], dict[str, object]]] = {
            "/control/p": lambda: camera.set(order),
            "/control/startRecording": camera.start_recording,
            "/control/stopRecording": camera.stop_recording,
            "/control/flushRecording": camera.flush,
            "/control/startFilesave": lambda: camera.save(order),
        }
        if self.path not in orders:
            self._send(404, b"no such order", "text/plain")
            return
        if camera.fault is CameraFault.REFUSES:
            self._answer({"error": "Operation not permitted"})
            return
        self._answer(orders[self.path]())

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""

    def _answer(self, document: dict[str, object]) -> None:
        if self.camera.fault is CameraFault.SILENT:
            self.ending.wait(SILENCE_S)
            return
        text = json.dumps(document).encode()
        if self.camera.fault is CameraFault.NO_JSON:
            text = b"<html>router</html>"
        self._send(200, text, "application/json")

    def _send(self, status: int, data: bytes, kind: str) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)
