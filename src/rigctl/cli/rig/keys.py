"""`rigctl keys`: keys with names, for people and programs; the daemon follows at once."""

from __future__ import annotations

import getpass
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import asdict
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Annotated

import typer

from rigctl.access.named_keys import KeyFile, NamedKey, hashed
from rigctl.access.scopes import Scope
from rigctl.access.strength import new_key
from rigctl.cli.options import Config, Json
from rigctl.cli.output import print_json
from rigctl.config import load
from rigctl.errors import SettingsError, StoreError
from rigctl.opening import own_store
from rigctl.store import Store
from rigctl.store.integrity.seal import read_secret

Name = Annotated[str, typer.Argument(help="Of the person or program; the audit knows it.")]


def add(
    name: Name,
    *,
    scope: Annotated[list[Scope], typer.Option(help="What it may do; stands once for each.")],
    expires: Annotated[
        str | None, typer.Option(help="When it ends: days as in 30d, or a time (ISO 8601, UTC).")
    ] = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """Add a key and print it, this once.

    Raises
    ------
    SettingsError
        The name is taken or none, or the time is none or past.
    StoreError
        The store cannot be written.
    """
    now = datetime.now(UTC)
    ends = None if expires is None else _moment(expires, now).isoformat(timespec="seconds")
    key = new_key()
    with _changed(config) as store:
        secret = read_secret(store.path)
        if secret is None:
            raise StoreError("has no key of the audit", part=str(store.path))
        kept = NamedKey(
            name=name,
            scopes=tuple(sorted(set(scope))),
            digest=hashed(key, secret),
            added_at=now.isoformat(timespec="seconds"),
            expires_at=ends,
        )
        KeyFile(store.path).add(kept)
        store.edits.key_changed(_actor(), "key added", name, _said(kept))
    if json:
        print_json({"name": name, "key": key, "expires_at": ends})
        return
    typer.echo(key)
    typer.echo(f"rigctl: the key of {name}: {_said(kept)}; it is not shown again", err=True)


def list_keys(*, config: Config = None, json: Json = False) -> None:
    """Print every named key without its hash."""
    now = datetime.now(UTC)
    found = KeyFile(Path(load(config).store.folder)).all()
    if json:
        listed = [asdict(key) | {"valid": key.refusal(now) is None} for key in found]
        print_json([{k: v for k, v in one.items() if k != "digest"} for one in listed])
        return
    for key in found:
        typer.echo(f"{key.name}: {_said(key)}")


def revoke(name: Name, *, config: Config = None) -> None:
    """Let a key open nothing any more, from now on.

    Raises
    ------
    NotFoundError
        There is no key of this name.
    StoreError
        The store cannot be written.
    """
    with _changed(config) as store:
        key = KeyFile(store.path).revoke(name, datetime.now(UTC))
        store.edits.key_changed(_actor(), "key revoked", name, _said(key))
    typer.echo(f"{name}: {_said(key)}")


@contextmanager
def _changed(configuration: Path | None) -> Iterator[Store]:
    with closing(own_store(load(configuration), shared=True)) as store:
        yield store


def _actor() -> str:
    return f"{getpass.getuser()} on the command line"


def _said(key: NamedKey) -> str:
    if key.revoked_at is not None:
        return f"revoked at {key.revoked_at}"
    ends = "never expires" if key.expires_at is None else f"expires at {key.expires_at}"
    return f"{', '.join(key.scopes)}; {ends}"


def _moment(text: str, now: datetime) -> datetime:
    """Return a time that is ahead: a date or time in ISO 8601, UTC, or so many days as in `30d`."""
    try:
        if text.endswith("d"):
            moment = now + timedelta(days=int(text[:-1]))
        else:
            moment = datetime.fromisoformat(text)
    except (ValueError, OverflowError):
        moment = None
    if moment is not None and moment.tzinfo is None:
        moment = moment.replace(tzinfo=UTC)
    if moment is None or moment <= now:
        raise SettingsError(
            "is no time to come",
            part="--expires",
            value=repr(text),
            limit="days as in 30d, or a time as in 2027-01-31T12:00Z",
            todo="correct it",
        )
    return moment
