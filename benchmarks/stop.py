"""How soon a stop reaches the line, and the dead man: python -m benchmarks.stop.

The laboratory is a process of its own (`python -m simulators`), the daemon another, as on a real
rig. Each stop is timed from the first byte of its connection to the simulated relay's switching,
on the host's one monotonic clock, through the stop's own port and through the service's, while
load comes from further processes. From SIGKILL or SIGSTOP of the daemon it is timed until the
power is off: once with every watch, and once with that of the trigger box alone, whose contact
then lies in the power's line. Prints a table and writes out/stop.json; ends 1 if a stop was lost,
or power stayed on for more than a second after the daemon's end.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import http.client
import json
import os
import pty
import resource
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

OUT = Path("out/stop.json")
CONFIGURATION = Path(__file__).parents[1] / "config" / "simulated.toml"
KEY = "the-key-of-the-stop-benchmark"
WITHIN_S = 30.0
MEDIAN_BAR_MS, LONGEST_BAR_MS, OFF_BAR_S = 20.0, 250.0, 1.0
LOADS = {
    "event streams": ("streams", 500),
    "idle connections": ("idle", 1000),
    "clients post 950 kB": ("post", 3),
    "loops over openapi.json": ("openapi", 20),
}
SILENT = ("trigger", "regulator", "slide", "recorder")


@dataclass(slots=True)
class Series:
    """Stops of one kind: times to the line and to the answer in ms, and how many were lost."""

    to_line_ms: list[float] = field(default_factory=list)
    to_answer_ms: list[float] = field(default_factory=list)
    lost: int = 0

    def line(self, name: str) -> str:
        """Return a row of the table."""
        times = self.to_line_ms or [float("nan")]
        return (
            f"{name:48} {statistics.median(times):8.1f} {max(times):8.1f} "
            f"{statistics.median(self.to_answer_ms or [float('nan')]):8.1f} {self.lost:4d}"
        )


class Apparatus:
    """A laboratory and a daemon, each in a process of its own, with real ports between them."""

    def __init__(self, folder: Path, *, box_alone: bool = False) -> None:
        self._folder, self._box_alone = folder, box_alone
        folder.mkdir(exist_ok=True)
        words = [sys.executable, "-m", "simulators", str(folder / "laboratory")]
        words += ["--watch-contact"] if box_alone else []
        self.laboratory = subprocess.Popen(words, stdout=subprocess.PIPE)
        assert self.laboratory.stdout is not None
        self._paths = json.loads(self.laboratory.stdout.readline())
        self._contact = pty.openpty()
        (folder / "rig.toml").write_text(self._configuration())
        self.start()

    def _configuration(self) -> str:
        text = CONFIGURATION.read_text()
        before, _, after = text.partition("[simulation]")
        text = before + after[after.index("[limits]") :]
        hid = '[camera.remote_trigger]\ndriver = "hid-relay"\nchannel = 1'
        contact = os.ttyname(self._contact[1])
        text = text.replace(
            hid, f'[camera.remote_trigger]\ndriver = "serial-line"\nport = "{contact}"'
        )
        for role in ("trigger", "regulator", "slide", "cut-off", "recorder", "capture"):
            text = text.replace(f'"sim:{role}"', f'"{self._paths[role]}"')
        if self._box_alone:
            text = text.replace("[cut_off]", "[cut_off]\ndead_man = false")
        return text.replace('folder = "data"', f'folder = "{self._folder / "data"}"')

    def start(self) -> None:
        """Start the daemon, and release the rig where it starts latched."""
        (self._folder / "data" / "service.json").unlink(missing_ok=True)
        words = [sys.executable, "-c", "from rigctl.cli import main; main()", "serve"]
        words += ["--config", "rig.toml", "--port", "0"]
        log = (self._folder / "serve.log").open("a")
        self.daemon = subprocess.Popen(
            words, cwd=self._folder, env=os.environ | {"RIGCTL_KEY": KEY}, stdout=log, stderr=log
        )
        address = self._folder / "data" / "service.json"
        until(lambda: self.daemon.poll() is not None or (address.exists() and self._lives(address)))
        if self.daemon.poll() is not None:
            raise SystemExit((self._folder / "serve.log").read_text())
        self.release()

    def _lives(self, address: Path) -> bool:
        about = json.loads(address.read_text())
        self.url, self.stop_url = str(about["url"]), str(about["stop_url"])
        with contextlib.suppress(OSError):
            return ask(self.url, "GET", "/health/live")[0] == 200
        return False

    def tell(self, **request: object) -> dict[str, Any]:
        """Ask the laboratory's control socket."""
        with socket.socket(socket.AF_UNIX) as link:
            link.connect(self._paths["control"])
            link.sendall(json.dumps(request).encode() + b"\n")
            return dict(json.loads(link.makefile().readline()))

    def power(self) -> tuple[bool, float]:
        """Return whether the actuators have power, and since when."""
        state = self.tell(state=True)["state"]
        return bool(state["powered"]), float(state["power_switched_s"] or 0.0)

    def release(self) -> None:
        """Give power back, as soon as the rig allows it."""
        self.tell(clear=True)

        def released() -> bool:
            if self.power()[0]:
                return True
            body = json.dumps({"reason": "the benchmark goes on"})
            ask(self.url, "POST", "/api/v1/rig/release", body)
            return self.power()[0]

        until(released)

    def close(self) -> None:
        """End both processes."""
        self.daemon.terminate()
        self.daemon.wait(WITHIN_S)
        self.laboratory.terminate()
        self.laboratory.wait(WITHIN_S)


def until(condition: Callable[[], bool]) -> None:
    """Return once the condition holds; end the benchmark when it does not."""
    ends = time.monotonic() + WITHIN_S
    while not condition():
        if time.monotonic() > ends:
            raise SystemExit(f"waited {WITHIN_S:g} s in vain")
        time.sleep(0.01)


def ask(url: str, method: str, path: str, body: str | None = None) -> tuple[int, bytes]:
    """Send one request over a connection of its own; return status and body."""
    parts = urlsplit(url)
    link = http.client.HTTPConnection(str(parts.hostname), parts.port or 80, timeout=WITHIN_S)
    with contextlib.closing(link):
        headers = {"Authorization": f"Bearer {KEY}", "Content-Type": "application/json"}
        link.request(method, path, body, headers)
        answer = link.getresponse()
        return answer.status, answer.read()


def stop_once(rig: Apparatus, url: str, found: Series) -> None:
    """Stop once, note when the relay switched, and give power back."""
    began = time.monotonic()
    try:
        ask(url, "POST", "/api/v1/rig/estop", "")
    except OSError:
        found.lost += 1
    found.to_answer_ms.append(1e3 * (time.monotonic() - began))
    ends = time.monotonic() + 1.0
    while (powered := rig.power())[0] and time.monotonic() < ends:
        pass
    if powered[0]:
        found.lost += 1
    else:
        found.to_line_ms.append(1e3 * (powered[1] - began))
    rig.release()


@contextlib.contextmanager
def load(rig: Apparatus, kind: str, count: int) -> Iterator[None]:
    """Have a process of its own load the service for the length of a `with` block."""
    words = [sys.executable, "-m", "benchmarks.stop", "--load", kind, str(count), rig.url]
    process = subprocess.Popen(words, stdout=subprocess.PIPE)
    assert process.stdout is not None
    process.stdout.readline()
    try:
        yield
    finally:
        process.kill()
        process.wait()


async def press(kind: str, count: int, url: str) -> None:
    """Load a service in one way until killed; says `ready` once every connection stands."""
    parts = urlsplit(url)
    host, port = str(parts.hostname), parts.port or 80
    head = f"Host: {host}:{port}\r\nAuthorization: Bearer {KEY}\r\n"
    steps = [{"pressure_a_kpa": 40.0, "offset_mm": 6.0, "delay_us": "none"}] * 13_000
    body = json.dumps({"table": steps})
    asked = {
        "streams": f"GET /api/v1/events HTTP/1.1\r\n{head}\r\n",
        "idle": "",
        "post": f"POST /api/v1/sweeps HTTP/1.1\r\n{head}Idempotency-Key: k\r\n"
        f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n{body}",
        "openapi": f"GET /openapi.json HTTP/1.1\r\n{head}\r\n",
    }[kind].encode()
    again = kind in {"post", "openapi"}

    async def one() -> None:
        while True:
            with contextlib.suppress(OSError, asyncio.IncompleteReadError):
                reader, writer = await asyncio.open_connection(host, port)
                writer.write(asked)
                while await reader.read(65536):
                    if again:
                        break
                writer.close()
            if not again:
                await asyncio.sleep(0.05)

    callers = [asyncio.create_task(one()) for _ in range(count)]
    await asyncio.sleep(2.0)
    print("ready", flush=True)
    await asyncio.gather(*callers)


def dead_man(rig: Apparatus, signalled: signal.Signals, times: int) -> tuple[list[float], int]:
    """Kill or halt the daemon; return the times to power off in s, and how often it stayed on."""
    found, stayed = [], 0
    for _ in range(times):
        began = time.monotonic()
        os.kill(rig.daemon.pid, signalled)
        ends = began + 5.0
        while (powered := rig.power())[0] and time.monotonic() < ends:
            time.sleep(0.002)
        stayed += powered[0]
        if not powered[0]:
            found.append(powered[1] - began)
        rig.daemon.kill()
        rig.daemon.wait()
        rig.start()
    return found, stayed


def ends_of_the_daemon(rig: Apparatus, kills: int, whose: str) -> dict[str, Any]:
    """Kill and halt the daemon; print and return the times to power off by the name of each."""
    cuts = {}
    for signalled in (signal.SIGKILL, signal.SIGSTOP):
        taken, stayed = dead_man(rig, signalled, kills)
        longest = max(taken, default=float("nan"))
        name = f"{signalled.name}, {whose}"
        print(f"{name}: to power off longest {longest:.2f} s of {kills}, on: {stayed}", flush=True)
        cuts[name] = {"to_off_s": taken, "stayed_on": stayed}
    return cuts


def measure(rig: Apparatus, times: int, kills: int, found: dict[str, Series]) -> dict[str, Any]:
    """Run every series; return the dead man's."""

    def series(name: str, before: Callable[[], object] = lambda: None) -> None:
        for way, url in (("stop's port", rig.stop_url), ("service", rig.url)):
            part = found.setdefault(f"{name}, by the {way}", Series())
            for _ in range(times):
                before()
                stop_once(rig, url, part)
            print(part.line(f"{name}, by the {way}"), flush=True)

    series("idle")
    for name, (kind, count) in LOADS.items():
        with load(rig, kind, count):
            series(f"{count} {name}")
    series("slide stuck", lambda: rig.tell(fault={"device": "slide", "kind": "stuck"}))
    series(
        "all other devices silent",
        lambda: [rig.tell(fault={"device": part, "kind": "no-answer"}) for part in SILENT],
    )
    return ends_of_the_daemon(rig, kills, "every watch")


@contextlib.contextmanager
def apparatus(folder: Path, *, box_alone: bool = False) -> Iterator[Apparatus]:
    """Start laboratory and daemon, and end them with the `with` block."""
    rig = Apparatus(folder, box_alone=box_alone)
    try:
        yield rig
    finally:
        rig.close()


def main() -> int:
    """Measure, print and write."""
    asked = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    asked.add_argument("--times", type=int, default=100, help="stops of each kind")
    asked.add_argument("--kills", type=int, default=5, help="ends of the daemon of each kind")
    asked.add_argument("--out", type=Path, default=OUT)
    asked.add_argument("--load", nargs=3, help=argparse.SUPPRESS)
    options = asked.parse_args()
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 8192), hard))
    if options.load:
        kind, count, url = options.load
        asyncio.run(press(kind, int(count), url))
    found: dict[str, Series] = {}
    print(f"{'stop, ms':48} {'median':>8} {'longest':>8} {'answer':>8} lost")
    with tempfile.TemporaryDirectory() as temporary:
        with apparatus(Path(temporary) / "whole") as rig:
            cuts = measure(rig, options.times, options.kills, found)
        with apparatus(Path(temporary) / "box", box_alone=True) as rig:
            cuts |= ends_of_the_daemon(rig, options.kills, "the box alone")
    lost = sum(part.lost for part in found.values())
    stayed = sum(int(cut["stayed_on"]) for cut in cuts.values())
    slow = [
        name
        for name, part in found.items()
        if statistics.median(part.to_line_ms) > MEDIAN_BAR_MS
        or max(part.to_line_ms) > LONGEST_BAR_MS
    ]
    late = [name for name, cut in cuts.items() if max(cut["to_off_s"], default=0.0) > OFF_BAR_S]
    print(f"lost: {lost}; power stayed on: {stayed}")
    print(
        f"above the bars of {MEDIAN_BAR_MS:g}, {LONGEST_BAR_MS:g} ms, 1 s: {slow + late or 'none'}"
    )
    document = {"stops": {name: asdict(part) for name, part in found.items()}, "dead_man": cuts}
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(document, indent=1) + "\n")
    return 1 if lost or stayed or late else 0


if __name__ == "__main__":
    sys.exit(main())
