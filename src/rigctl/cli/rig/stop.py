"""`rigctl stop` and `rigctl release`: the emergency stop, and the way out of its latch."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import httpx
import typer

from rigctl.cli.options import Config, Json, Key, KeyFile, given_key
from rigctl.cli.output import print_json
from rigctl.client import connected, error_of
from rigctl.config import load
from rigctl.errors import ConfigurationError, DeviceError
from rigctl.service import keyfile
from rigctl.service.guards.auth import ESTOP_PATH

STOP_WITHIN_S = 5.0
"""Longest wait for one address to answer: the cut, its confirmation and the record of both, s."""


def stop(
    *,
    reason: Annotated[
        str, typer.Option(help="Why; it is kept with the stop.")
    ] = "stopped by command",
    config: Config = None,
    json: Json = False,
) -> None:
    """Stop the rig of a configuration, through the stop's own port, or else the service's.

    Needs no key. A stop may be repeated, so that each address is tried.

    Raises
    ------
    DeviceError
        No address answered: the power may be on.
    RigError
        The rig is latched, and its power is not known to be off.
    """
    failures = []
    for url in _addresses(config):
        try:
            answer = httpx.post(
                url + ESTOP_PATH, json={"reason": reason}, timeout=STOP_WITHIN_S, trust_env=False
            )
        except httpx.TransportError as error:
            failures.append(f"{url}: {type(error).__name__}")
            continue
        if not answer.is_success:
            raise error_of(answer)
        _print(dict(answer.json()), as_json=json)
        return
    raise DeviceError(
        "no daemon took the stop",
        value="; ".join(failures),
        todo="switch the actuators off by hand",
    )


def release(
    reason: Annotated[str, typer.Argument(help="What was found and done.")],
    *,
    config: Config = None,
    key: Key = None,
    key_file: KeyFile = None,
    json: Json = False,
) -> None:
    """Let the rig leave its latch, after a person has looked; raise what the daemon answers."""
    with connected(config, given_key(key, key_file)) as daemon:
        _print(daemon.release(reason), as_json=json)


def _addresses(path: Path | None) -> list[str]:
    configuration = load(path)
    service = configuration.service
    try:
        address = keyfile.read(Path(configuration.store.folder))
    except ConfigurationError:
        return [f"http://{service.host}:{service.port}"]
    return [url for url in (address.stop_url, address.url) if url]


def _print(rig: dict[str, Any], *, as_json: bool) -> None:
    if as_json:
        print_json(rig)
        return
    typer.echo(f"{rig['name']}: {rig['state']}: {rig['reason']}")
    for warning in rig["warnings"]:
        typer.echo(f"warning: {warning}", err=True)
