"""`rigctl shots`: list stored shots, leave one out of every fit, let it count, note, tag."""

from __future__ import annotations

import getpass
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from rigctl.cli.options import Config, Json
from rigctl.cli.output import print_json
from rigctl.config import load
from rigctl.errors import NotFoundError, SettingsError
from rigctl.opening import own_store
from rigctl.plain_text import LONGEST_TAG, require_word
from rigctl.service.models import ShotView
from rigctl.store import ShotRecord, ShotState, Store

_ALL = 1_000_000


Shot = Annotated[str, typer.Argument(help="Its name, or its number.")]
Several = Annotated[list[str], typer.Argument(help="Their names, or their numbers.")]
Of = Annotated[
    str | None,
    typer.Option("--campaign", help="Numbers are those of this campaign, as its fits name them."),
]


def list_shots(
    *,
    campaign: Annotated[str | None, typer.Option(help="Only those of this campaign.")] = None,
    state: Annotated[str | None, typer.Option(help="Only those that stand there.")] = None,
    tag: Annotated[str | None, typer.Option(help="Only those with this tag.")] = None,
    excluded: Annotated[
        bool | None,
        typer.Option("--excluded/--counting", help="Only those that do not count, or that do."),
    ] = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """Print the shots that fulfil all conditions, oldest first.

    Raises
    ------
    NotFoundError
        There is no such campaign, or no store.
    SettingsError
        No state has that name.
    """
    wanted = None if state is None else _state_named(state)
    with kept(config) as store:
        if campaign is not None:
            store.campaigns.one(campaign)
        found = store.shots(campaign=campaign, state=wanted, tag=tag, excluded=excluded, limit=_ALL)
        _print(found, as_json=json)
        if not found:
            typer.echo("rigctl: no stored shot fulfils this", err=True)


def exclude(
    shot: Several,
    *,
    reason: Annotated[str, typer.Option(help="Why; the audit keeps it.")],
    campaign: Of = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """Leave shots out of every fit; raise `SettingsError` without a reason."""
    with kept(config) as store:
        shots = _found(store, shot, campaign)
        _print([store.exclude(each, reason, actor()) for each in shots], as_json=json)


def include(
    shot: Several, *, campaign: Of = None, config: Config = None, json: Json = False
) -> None:
    """Let shots count again."""
    with kept(config) as store:
        shots = _found(store, shot, campaign)
        _print([store.include(each, actor()) for each in shots], as_json=json)


def note(
    shot: Shot,
    text: Annotated[str | None, typer.Argument(help="Without it the note is taken away.")] = None,
    *,
    campaign: Of = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """Put a note in the place of a shot's note, or take it away."""
    with kept(config) as store:
        (found,) = _found(store, [shot], campaign)
        _print([store.annotate(found, text, actor())], as_json=json)


def tag(
    shot: Shot,
    tags: Annotated[list[str] | None, typer.Argument(help="Without any, all are taken away.")] = (
        None
    ),
    *,
    campaign: Of = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """Give a shot exactly these tags; raise `SettingsError` for a word that is none."""
    words = valid_tags(tags or [])
    with kept(config) as store:
        (found,) = _found(store, [shot], campaign)
        _print([store.tag(found, words, actor())], as_json=json)


def _state_named(name: str) -> ShotState:
    """Return a state; `SettingsError`, if there is none of that name, lists those there are."""
    try:
        return ShotState(name)
    except ValueError as error:
        raise SettingsError(
            "no shot can stand there", part="--state", value=repr(name), limit=", ".join(ShotState)
        ) from error


@contextmanager
def kept(configuration: Path | None) -> Iterator[Store]:
    """Open the store of a configuration beside whatever daemon runs on it.

    Raises
    ------
    NotFoundError
        There is no store there.
    ConfigurationError, StoreError
        Configuration or store cannot be read.
    """
    found = load(configuration)
    folder = Path(found.store.folder)
    if not folder.is_dir():
        raise NotFoundError(
            "holds no shots",
            part=str(folder),
            todo="start in the folder the daemon was started in, or name its --config",
        )
    store = own_store(found, shared=True)
    try:
        yield store
    finally:
        store.close()


def valid_tags(tags: Collection[str]) -> list[str]:
    """Return words that may be tags; raise `SettingsError` for one that may not."""
    return [require_word(tag, "is not a tag", "tag", longest=LONGEST_TAG) for tag in tags]


def actor() -> str:
    """Return whom the audit names for what is done on the command line."""
    return f"{getpass.getuser()} on the command line"


def _found(store: Store, names: Sequence[str], campaign: str | None) -> list[str]:
    """Return the whole names of shots, each given by that or by its number; all, or an error."""
    return [
        store.catalogue.numbered(int(name), campaign).id
        if name.isdecimal()
        else store.shot(name).id
        for name in names
    ]


def _print(shots: Sequence[ShotRecord], *, as_json: bool) -> None:
    if as_json:
        listed = [ShotView.of(shot).model_dump(mode="json") for shot in shots]
        print_json({"shots": listed})
        return
    table = Table(box=None, padding=(0, 2, 0, 0))
    for heading in ("shot", "campaign", "state", "tags", "excluded", "note"):
        table.add_column(heading, overflow="fold")
    for shot in shots:
        words = (shot.campaign, shot.state, ",".join(shot.tags), shot.excluded, shot.note)
        table.add_row(shot.id, *(word or "" for word in words))
    Console(highlight=False, soft_wrap=True).print(table)
