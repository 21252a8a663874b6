"""`rigctl serve`: the daemon in one process, from opened devices to a rig left safe."""

from __future__ import annotations

import asyncio
import os
import signal
import socket
import sys
import threading
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Annotated

import typer
import uvicorn
from starlette.types import ASGIApp

from rigctl import logs, systemd
from rigctl.access.strength import new_key, require_strong
from rigctl.cli.options import Config, KeyFile, OwnEffects, given_key
from rigctl.cli.rig.listening import listen, listen_for_stops, url_of
from rigctl.config import Configuration, load
from rigctl.daemon import open_daemon
from rigctl.jobs.worker_process import hide_from_jobs
from rigctl.logs import LogFormat
from rigctl.page.mounting import with_page
from rigctl.service import keyfile
from rigctl.service.app import create_app
from rigctl.service.events import EventHub
from rigctl.service.guards.connections import Connections, raise_descriptor_limit, room_for
from rigctl.service.guards.origins import AnswerHeaders, OriginGuard, OwnOrigins, behind_proxy
from rigctl.service.keyfile import ServiceAddress
from rigctl.service.stop_port import StopPort
from rigctl.store import StepState, SweepRecord
from rigctl.systemd import Watchdog

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
        systemd.notify(systemd.READY)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        self._ends = True
        systemd.notify(systemd.STOPPING)
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
