"""`rigctl serve`: the daemon in one process, from opened devices to a rig left safe.

Signs of life go to systemd for a unit of type `notify` with a watchdog, by the protocol of
sd_notify(3): datagrams to the socket that `NOTIFY_SOCKET` names; no effect elsewhere.
"""

from __future__ import annotations

import asyncio
import contextlib
import ipaddress
import os
import shlex
import signal
import socket
import ssl
import sys
import threading
from collections.abc import Callable
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Annotated

import typer
import uvicorn
from starlette.types import ASGIApp

from rigctl import logs
from rigctl.access.strength import new_key, require_strong
from rigctl.cli.options import Config, KeyFile, OwnEffects, given_key
from rigctl.config import Configuration, load
from rigctl.config.configuration import ServiceSection
from rigctl.daemon import open_daemon
from rigctl.errors import ConfigurationError
from rigctl.jobs.worker_process import hide_from_jobs
from rigctl.logs import LogFormat
from rigctl.page.mounting import with_page
from rigctl.rig.status import RigStatus
from rigctl.service import keyfile
from rigctl.service.app import create_app
from rigctl.service.events import EventHub
from rigctl.service.guards.connections import Connections, raise_descriptor_limit, room_for
from rigctl.service.guards.origins import AnswerHeaders, OriginGuard, OwnOrigins, behind_proxy
from rigctl.service.keyfile import ServiceAddress
from rigctl.service.stop_port import StopPort
from rigctl.store import StepState, SweepRecord

READY, STOPPING, ALIVE = "READY=1", "STOPPING=1", "WATCHDOG=1"


def notify(state: str) -> None:
    """Send a state to the service manager, if there is one. Never raises."""
    address = os.environ.get("NOTIFY_SOCKET", "")
    if address[:1] not in {"/", "@"}:
        return
    if address.startswith("@"):
        address = "\0" + address[1:]
    with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as link:
        link.connect(address)
        link.send(state.encode())


def watchdog_period_s() -> float | None:
    """Return how often a sign of life is due, s: a third of what the unit allows; None: never."""
    try:
        return int(os.environ["WATCHDOG_USEC"]) * 1e-6 / 3
    except (KeyError, ValueError):
        return None


class Watchdog:
    """Sends a sign of life while `alive` returns true, in a thread of its own.

    Parameters
    ----------
    alive
        Called before each sign; returns within a bound.
    """

    def __init__(self, alive: Callable[[], bool]) -> None:
        self._alive, self._ended = alive, threading.Event()
        self._period_s = watchdog_period_s()
        self._thread = threading.Thread(target=self._send, name="watchdog", daemon=True)
        if self._period_s is not None:
            self._thread.start()

    def close(self) -> None:
        """Send no more."""
        self._ended.set()

    def _send(self) -> None:
        while not self._ended.wait(self._period_s):
            if self._alive():
                notify(ALIVE)


STOP_PORT_ABOVE = 1000
"""The stop's own port lies so far above the service's, unless it is set or taken."""


def listen(section: ServiceSection, port: int | None) -> socket.socket:
    """Return the socket of the service; `port` replaces that of the configuration.

    Raises
    ------
    ConfigurationError
        The port is taken, the certificate is of no use, or the rig would be open to the network
        without encryption.
    """
    require_safe(section)
    chosen = section.port if port is None else port
    return _bound(
        section.host, chosen, "service.port", "choose another with --port, 0 for any free one"
    )


def require_safe(section: ServiceSection) -> None:
    """Refuse an address that is open to the network, or a certificate that is of no use.

    Raises
    ------
    ConfigurationError
        As `listen`.
    """
    host = section.host
    if not (_is_loopback(host) or section.encrypts or section.proxy):
        raise ConfigurationError(
            "keys and orders would cross the network for everybody to read",
            part="service.host",
            value=repr(host),
            limit="a loopback address, or an encrypted connection",
            todo="set service.tls_certificate and service.tls_key, or name in service.proxy the "
            "reverse proxy that encrypts, or listen on 127.0.0.1",
        )
    _require_certificate(section)


def listen_for_stops(section: ServiceSection, listening: socket.socket) -> socket.socket:
    """Listen on the stop's own port: the one that is set, 1000 above the service's, or any.

    Raises
    ------
    ConfigurationError
        The port that is set is taken.
    """
    if section.stop_port is not None:
        todo = "choose another stop_port, 0 for any free one"
        return _bound(section.host, section.stop_port, "service.stop_port", todo)
    beside = int(listening.getsockname()[1]) + STOP_PORT_ABOVE
    try:
        return _bound(section.host, beside if beside <= 65535 else 0, "service.stop_port", "")
    except ConfigurationError:
        return _bound(section.host, 0, "service.stop_port", "set stop_port")


def _bound(host: str, port: int, part: str, todo: str) -> socket.socket:
    try:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        return socket.create_server((host, port), family=family)
    except OSError as error:
        raise ConfigurationError(
            f"cannot listen there: {error.strerror or error}",
            part=part,
            value=f"{host}:{port}",
            todo=todo,
        ) from error


def url_of(listening: socket.socket, *, encrypts: bool) -> str:
    """Return the address of a socket, as in `http://127.0.0.1:8486`."""
    host, port = listening.getsockname()[:2]
    scheme = "https" if encrypts else "http"
    return f"{scheme}://[{host}]:{port}" if ":" in host else f"{scheme}://{host}:{port}"


def _require_certificate(section: ServiceSection) -> None:
    if section.tls_certificate is None:
        return
    try:
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(section.tls_certificate, section.tls_key)
    except OSError as error:
        raise ConfigurationError(
            f"certificate and key cannot be used: {error.strerror or error}",
            part="service.tls_certificate",
            value=f"{section.tls_certificate} with {section.tls_key}",
            todo="name PEM files that belong together and that the daemon may read",
        ) from error


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


SWITCH_S = 0.001
"""Threads that compute give way to those that answer after this time, s."""

ANSWERS_WITHIN_S = 1.0
"""Longest time in which a service that lives takes a call, s."""

END_WITHIN_S = 5
"""Longest wait for answers under way when the service ends; they are cut off after it."""


class _Server(uvicorn.Server):
    """Lets listening clients go before it waits for connections to end, and tells systemd."""

    def __init__(self, config: uvicorn.Config, hub: EventHub) -> None:
        super().__init__(config)
        self._hub = hub
        self._loop: asyncio.AbstractEventLoop | None = None
        self._ends = False

    def answers(self) -> bool:
        """Say within `ANSWERS_WITHIN_S` whether the event loop takes calls, or need not any more.

        What leaves the rig safe after the service's end may take longer than a watchdog waits.
        """
        taken = threading.Event()
        if self._loop is None or self._ends:
            return self._ends
        with suppress(RuntimeError):
            self._loop.call_soon_threadsafe(taken.set)
        return taken.wait(ANSWERS_WITHIN_S)

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        self._loop = asyncio.get_running_loop()
        notify(READY)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        self._ends = True
        notify(STOPPING)
        self._hub.close()
        await super().shutdown(sockets)


def serve(
    *,
    config: Config = None,
    port: Annotated[
        int | None,
        typer.Option(min=0, max=65535, help="Listen here instead; 0 takes any free port."),
    ] = None,
    key: Annotated[
        str | None,
        typer.Option(help="Key of the service; best in RIGCTL_KEY. Without any a fresh one."),
    ] = None,
    key_file: KeyFile = None,
    effects: OwnEffects = None,
    log: Annotated[
        LogFormat,
        typer.Option(help="What goes to standard error: warnings, or every step as JSON lines."),
    ] = "text",
) -> None:
    """Run the daemon until SIGINT or SIGTERM; the rig is left safe, within a bound.

    `effects` takes the place of the folder that the configuration names.

    Raises
    ------
    ConfigurationError
        The configuration cannot be, the key is too weak, the port is taken, or the rig would be
        open to the network without encryption.
    RigError
        A device or the store cannot be opened.
    """
    # What the daemon and its jobs write is for their owner alone.
    os.umask(0o077)
    # SIGTERM unwinds like Ctrl-C, also while devices are being opened and after the server ended.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    chosen = given_key(key, key_file)
    if chosen is not None:
        require_strong(chosen.key)
    configuration = _with_effects(load(config), effects)
    logs.set_up(log)
    sys.setswitchinterval(SWITCH_S)
    descriptors = raise_descriptor_limit()
    section = configuration.service
    listening = listen(section, port)
    stop_listening = listen_for_stops(section, listening)
    address = ServiceAddress(
        url_of(listening, encrypts=section.encrypts),
        new_key() if chosen is None else chosen.key,
        section.tls_certificate,
        url_of(stop_listening, encrypts=False),
    )
    origins = OwnOrigins((section.host, *section.names))
    try:
        with (
            ExitStack() as last,
            listening,
            stop_listening,
            open_daemon(configuration) as daemon,
            ExitStack() as opened,
        ):
            opened.callback(StopPort(stop_listening, daemon.rig, origins).close)
            written = keyfile.write(daemon.store.path, address)
            hide_from_jobs(written)
            try:
                hub = EventHub()
                page = with_page(create_app(daemon, address.key, hub), daemon)
                guarded = AnswerHeaders(OriginGuard(behind_proxy(page, section.proxy), origins))
                connections = Connections(room_for(descriptors))
                server = _server(guarded, configuration, hub, connections)
                # It goes on until the rig is safe: a shot under way ends first.
                last.callback(Watchdog(lambda: server.answers() and daemon.rig.answers()).close)
                opened.callback(daemon.rig.listeners.add(logs.transition))
                opened.callback(daemon.store.listeners.add(logs.shot))
                typer.echo(_greeting(address, configuration, chosen=chosen is not None))
                status = daemon.rig.status()
                if status.latch_reason is not None:
                    typer.echo(_latched(status, status.latch_reason, config))
                for sweep in daemon.offered:
                    typer.echo(_offer(sweep))
                server.run(sockets=[listening])
            finally:
                _finish_undisturbed()
                written.unlink(missing_ok=True)
    except KeyboardInterrupt:
        typer.echo("rigctl: ended, the rig is safe", err=True)


def _with_effects(configuration: Configuration, folder: Path | None) -> Configuration:
    if folder is None:
        return configuration
    analysis = configuration.analysis.model_copy(update={"effects": str(folder)})
    return configuration.model_copy(update={"analysis": analysis})


def _server(
    app: ASGIApp, configuration: Configuration, hub: EventHub, connections: Connections
) -> _Server:
    section = configuration.service
    settings = uvicorn.Config(
        app,
        http=connections.protocol(),  # type: ignore[arg-type]
        log_level="warning",
        access_log=False,
        server_header=False,
        # The client's address is that of the connection; of a header only where a proxy is named.
        proxy_headers=False,
        ssl_certfile=section.tls_certificate,
        ssl_keyfile=section.tls_key,
        timeout_graceful_shutdown=END_WITHIN_S,
        # Compressing messages to open pages holds up the event loop, and with it a fire request.
        ws_per_message_deflate=False,
    )
    return _Server(settings, hub)


def _greeting(address: ServiceAddress, configuration: Configuration, *, chosen: bool) -> str:
    kind = "simulated rig" if configuration.simulation else "REAL RIG"
    # Whoever chose the key knows it; a terminal and its log need not.
    key = "KEY, with the key that was chosen" if chosen else address.key
    return (
        f"rigctl: {kind} {configuration.name!r} at {address.url}/?key={key}\n"
        f"rigctl: a POST to {address.stop_url}/ stops it, as does `rigctl stop`"
    )


def _latched(status: RigStatus, reason: str, config: Path | None) -> str:
    named = "" if config is None else f" --config {shlex.quote(str(config))}"
    return (
        f"rigctl: the rig is latched ({status.state}) since {status.since:%Y-%m-%d %H:%M:%S} UTC "
        f"and fires nothing: {reason}\n"
        f'rigctl: look at it, then `rigctl release{named} "what was found and done"`'
    )


def _offer(sweep: SweepRecord) -> str:
    waiting = sweep.counts.get(StepState.WAITING, 0)
    return (
        f"rigctl: sweep {sweep.id} waits with {waiting} of {sweep.steps} steps: {sweep.reason}; "
        f"rigctl sweep resume {sweep.id}"
    )


def _finish_undisturbed() -> None:
    """Let no second signal interrupt what leaves the rig safe; every step of it has a bound."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
