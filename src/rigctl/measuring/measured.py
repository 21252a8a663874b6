"""Folders of the measured shots of a campaign; found without loading the analysis."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from rigctl.documents import Json
from rigctl.errors import AnalysisInputError
from rigctl.store import Store, StoreReader

MOST_SHOTS = 1_000_000
"""So many shots of one campaign are looked at."""


@dataclass(frozen=True, slots=True)
class MeasuredFiles:
    """Where a measured shot lies: its manifest and the result that counts.

    One that a person `excluded` is there to be named, and is left out of every fit.
    """

    manifest: Path
    result: Path
    excluded: bool = False


def measured_files(store: Store | StoreReader, name: str) -> list[MeasuredFiles]:
    """Return where the measured shots of a campaign lie, in the order of firing.

    Those that a person excluded come last.

    Raises
    ------
    NotFoundError
        There is no such campaign, or none of its shots is measured and counts.
    """
    return list(each_measured(store, name))


def each_measured(store: Store | StoreReader, name: str) -> Iterator[MeasuredFiles]:
    """Return the same, a shot at a time."""
    campaigns = store.campaigns
    for excluded, listed in ((False, campaigns.measured), (True, campaigns.left_out)):
        for shot, number in listed(name):
            folder = store.folders.folder(shot)
            result = folder / f"result-{number:04d}.json"
            yield MeasuredFiles(folder / "manifest.json", result, excluded)


def request(
    title: str,
    files: Sequence[MeasuredFiles],
    effects: Sequence[str] = (),
    store: Store | None = None,
) -> Json:
    """Return the argument of the functions of `modelling`.

    Parameters
    ----------
    store
        Where the campaign is; without it, it is not looked for tables that came in the place of
        poses.
    """
    listed = [
        {"manifest": str(own.manifest), "result": str(own.result), "excluded": own.excluded}
        for own in files
    ]
    place = {} if store is None else {"store": str(store.path), "database": store.address}
    return {"campaign": title, "files": listed, "with": list(effects), **place}


def others(store: Store, title: str, names: Sequence[str]) -> list[Json]:
    """Return the arguments of further campaigns that are asked together with one.

    Raises
    ------
    NotFoundError
        There is no such campaign, or none of its shots is measured and counts.
    AnalysisInputError
        One is the campaign itself: its shots would count twice.
    """
    if title in names:
        raise AnalysisInputError(
            f"{title} is asked together with itself, and its shots would count twice",
            part="together",
            todo="name other campaigns",
        )
    return [request(name, measured_files(store, name), (), store) for name in names]
