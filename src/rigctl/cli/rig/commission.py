"""`rigctl commission`: what must be seen of a real rig before it fires, step by step."""

from __future__ import annotations

import hmac
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from rigctl.cli.options import Config, Json, Key, KeyFile, given_key
from rigctl.cli.output import print_json, print_line
from rigctl.client import ServiceClient, connected
from rigctl.commissioning.answers import read_record, write_record
from rigctl.config import load
from rigctl.errors import NotFoundError, RefusedError, SettingsError

_WAYS = "y yes, n no, r do it again, l leave it asked for, q end here"


def commission(
    *,
    person: Annotated[
        list[str] | None,
        typer.Option("--person", help="Who looks; may be given several times."),
    ] = None,
    listed: Annotated[
        bool, typer.Option("--list", help="Show every step and how it stands; ask nothing.")
    ] = False,
    rewired: Annotated[
        str | None,
        typer.Option(help="Part whose wiring, board or firmware was worked on: asked for again."),
    ] = None,
    note: Annotated[str, typer.Option(help="What was done to the part.")] = "",
    record: Annotated[
        Path | None, typer.Option(help="Write the signed record (JSON) into this file.")
    ] = None,
    verify: Annotated[
        Path | None, typer.Option(help="Check the signature of a record with the store's key.")
    ] = None,
    config: Config = None,
    key: Key = None,
    key_file: KeyFile = None,
    json: Json = False,
) -> None:
    """Walk through the steps that are asked for; a real rig fires nothing before all are seen.

    Raises
    ------
    RefusedError
        A step is not as it must be, or a record's signature does not fit.
    NotFoundError
        The rig has no such part.
    SettingsError
        Nobody is named, nothing is said of what was done, or a record is none.
    """
    if verify is not None:
        _verify(verify, Path(load(config).store.folder))
        return
    with connected(config, given_key(key, key_file)) as daemon:
        if rewired is not None:
            _require_part(daemon, rewired, note)
            daemon.rewired(rewired, _people(person), note)
        elif not listed and record is None:
            _walk(daemon, _people(person))
        found = daemon.commissioning()
        if record is not None:
            write_record(record, daemon.commissioning_record())
    if json:
        print_json(found)
    elif listed or rewired is not None:
        _list(found)
    else:
        _print_end(found, record)


def _require_part(daemon: ServiceClient, part: str, note: str) -> None:
    """Refuse what the daemon would refuse, before anybody is asked for a name."""
    parts = list(dict.fromkeys(step["part"] for step in daemon.commissioning()["steps"]))
    if part not in parts:
        raise NotFoundError(
            "is no part of this rig", part=part, limit=", ".join(parts), todo="name one of them"
        )
    if not note.strip():
        raise SettingsError("is empty", part="note", todo="say with --note what was done")


def _people(given: list[str] | None) -> list[str]:
    people = given or [name.strip() for name in typer.prompt("Who looks?").split(",")]
    if not all(people):
        raise SettingsError("is empty", part="person", todo="name the person who looks")
    return people


def _walk(daemon: ServiceClient, people: list[str]) -> None:
    """Go through the steps that are asked for, in their order, until one fails or all are seen."""
    asked = [step for step in daemon.commissioning()["steps"] if step["missing"]]
    for number, step in enumerate(asked, 1):
        typer.echo(f"\n{number} of {len(asked)}  {step['title']} ({step['name']})")
        typer.echo(f"  asked for: {step['missing']}")
        typer.echo(f"  do:  {step['do']}")
        typer.echo(f"  see: {step['see']}")
        if not _ask(daemon, step, people):
            return


def _ask(daemon: ServiceClient, step: Mapping[str, Any], people: list[str]) -> bool:
    """Have a step done and answered; say whether to go on."""
    name, word = str(step["name"]), "r"
    while word == "r":
        if step["act"] is not None:
            typer.prompt(f"  Enter lets the daemon do its part ({step['act']})", "", False)
            found = daemon.do_step(name)
            typer.echo(f"  the daemon {'saw' if found['holds'] else 'MISSED'}: {found['text']}")
        word = typer.prompt(f"  Is it as stated? ({_WAYS})").strip().lower()[:1]
    if word == "y":
        daemon.answer_step(name, people, None, seen=True)
        return True
    if word == "n":
        seen = typer.prompt("  What was seen instead?")
        daemon.answer_step(name, people, seen, seen=False)
        raise RefusedError(
            f"step '{name}' is not as it must be: {seen}",
            todo="put it right, then run `rigctl commission` again: it goes on at this step",
        )
    if word == "l":
        typer.echo("  left: it stays asked for")
    return word == "l"


def _list(found: Mapping[str, Any]) -> None:
    for step in found["steps"]:
        said = (
            step["missing"] or f"seen on {step['answered_at'][:10]} by {', '.join(step['people'])}"
        )
        print_line(f"{'-' if step['missing'] else '+'} {step['name']}: {step['title']}; {said}")


def _print_end(found: Mapping[str, Any], record: Path | None) -> None:
    if record is not None:
        typer.echo(f"signed record written to {record}")
    if found["complete"]:
        typer.echo("Every step was seen: the rig may fire.")
        return
    typer.echo(f"Not complete; the next step is '{found['next']}'.")


def _verify(path: Path, store: Path) -> None:
    document, signature, own = read_record(path, store)
    if not hmac.compare_digest(signature, own):
        raise RefusedError(
            "the signature does not fit: another store's, or changed since",
            part=str(path),
            todo="write it anew with `rigctl commission --record`",
        )
    typer.echo(f"{path}: signed by this store on {document['at']}, people: {document['people']}")
