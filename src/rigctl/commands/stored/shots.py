"""`rigctl shots`: list stored shots, leave one out of every fit, let it count, note, tag."""

from __future__ import annotations

import getpass
import json
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from pydantic import TypeAdapter, ValidationError
from rich.console import Console
from rich.table import Table

from rigctl.config import load
from rigctl.errors import NotFoundError, SettingsError
from rigctl.opening import own_store
from rigctl.service.models import ShotView, Tag
from rigctl.store import ShotRecord, ShotState, Store

_TAGS = TypeAdapter[list[str]](list[Tag])
_ALL = 1_000_000


@dataclass(frozen=True, slots=True)
class Filter:
    """Which shots to list; None leaves a condition out."""

    campaign: str | None = None
    state: ShotState | None = None
    tag: str | None = None
    excluded: bool | None = None


def state_named(name: str) -> ShotState:
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


def show(store: Store, wanted: Filter, *, as_json: bool) -> None:
    """Print the shots that a filter finds, oldest first."""
    found = store.shots(
        campaign=wanted.campaign,
        state=wanted.state,
        tag=wanted.tag,
        excluded=wanted.excluded,
        limit=_ALL,
    )
    _print(found, as_json=as_json)


def exclude(
    store: Store, names: Sequence[str], reason: str, campaign: str | None, *, as_json: bool
) -> None:
    """Leave shots out of every fit; raise `SettingsError` without a reason."""
    shots = _found(store, names, campaign)
    _print([store.exclude(shot, reason, actor()) for shot in shots], as_json=as_json)


def include(store: Store, names: Sequence[str], campaign: str | None, *, as_json: bool) -> None:
    """Let shots count again."""
    shots = _found(store, names, campaign)
    _print([store.include(shot, actor()) for shot in shots], as_json=as_json)


def annotate(
    store: Store, name: str, note: str | None, campaign: str | None, *, as_json: bool
) -> None:
    """Put a note in the place of a shot's note, or take it away."""
    (shot,) = _found(store, [name], campaign)
    _print([store.annotate(shot, note, actor())], as_json=as_json)


def tag(
    store: Store, name: str, tags: Collection[str], campaign: str | None, *, as_json: bool
) -> None:
    """Give a shot exactly these tags; raise `SettingsError` for a word that is none."""
    words = valid_tags(tags)
    (shot,) = _found(store, [name], campaign)
    _print([store.tag(shot, words, actor())], as_json=as_json)


def valid_tags(tags: Collection[str]) -> list[str]:
    """Return words that may be tags; raise `SettingsError` for one that may not."""
    try:
        return _TAGS.validate_python(list(tags))
    except ValidationError as error:
        raise SettingsError(
            "is not a tag",
            part="tag",
            value=repr(error.errors()[0]["input"]),
            limit="1 to 32 letters, digits, dots, hyphens or underscores, first a letter or digit",
        ) from error


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
    console = Console(highlight=False, soft_wrap=True)
    if as_json:
        listed = [ShotView.of(shot).model_dump(mode="json") for shot in shots]
        console.file.write(json.dumps({"shots": listed}, allow_nan=False) + "\n")
        return
    table = Table(box=None, padding=(0, 2, 0, 0))
    for heading in ("shot", "campaign", "state", "tags", "excluded", "note"):
        table.add_column(heading, overflow="fold")
    for shot in shots:
        words = (shot.campaign, shot.state, ",".join(shot.tags), shot.excluded, shot.note)
        table.add_row(shot.id, *(word or "" for word in words))
    console.print(table)
