"""Fits of a campaign, saved under names: every version stays, none takes the place of another.

::

    campaigns/nylon-2/fits/base-0001.json      the first fit that was saved as `base`
                           base-0002.json      the second
"""

from __future__ import annotations

import json
import os
import re
import uuid
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rigctl.documents import Json
from rigctl.errors import NotFoundError, StoreError
from rigctl.store.durable import make_folders, sync_folder, write_synced

_FILE = re.compile(r"(?P<name>.+)-(?P<version>\d{4,})\.json")


class Fits:
    """The fits below `root`/campaigns. Any thread may call any of the methods."""

    def __init__(self, root: Path) -> None:
        self._campaigns = root / "campaigns"

    def add(self, campaign: str, name: str, document: Mapping[str, Any]) -> int:
        """Save a fit as the next version of its name; return the version, counted from 1.

        Raises
        ------
        StoreError
            The disk refused, or the document holds a number that is not finite.
        """
        folder = self._folder(campaign)
        partial = folder / f".{uuid.uuid4().hex}.partial"
        with _store_errors(folder):
            text = json.dumps(document, allow_nan=False, indent=1).encode()
            make_folders(folder)
            try:
                write_synced(partial, lambda file: file.write(text))
                version = self._link(partial, campaign, name)
            finally:
                partial.unlink(missing_ok=True)
            sync_folder(folder)
        return version

    def versions(self, campaign: str) -> list[tuple[str, int]]:
        """Return name and version of every saved fit of a campaign, in order."""
        found = [_FILE.fullmatch(path.name) for path in self._folder(campaign).glob("*.json")]
        return sorted((match["name"], int(match["version"])) for match in found if match)

    def fit(self, campaign: str, name: str, version: int | None = None) -> tuple[int, Json]:
        """Return one version of a fit, the latest by default, with its number.

        Raises
        ------
        NotFoundError
            No fit was saved under this name, or not in this version.
        StoreError
            The file cannot be read.
        """
        known = [number for own, number in self.versions(campaign) if own == name]
        if not known or (version is not None and version not in known):
            raise NotFoundError(
                "no such fit",
                part=f"campaign {campaign}",
                value=repr(name) if version is None else f"{name!r}, version {version}",
                todo="list the campaign's fits",
            )
        chosen = max(known) if version is None else version
        path = self._path(campaign, name, chosen)
        with _store_errors(path):
            document: Json = json.loads(path.read_bytes())
        return chosen, document

    def _link(self, partial: Path, campaign: str, name: str) -> int:
        """Give a whole file the next free version."""
        while True:
            known = [number for own, number in self.versions(campaign) if own == name]
            version = max(known, default=0) + 1
            try:
                # A link, unlike a rename, refuses to take the place of a file that is there.
                os.link(partial, self._path(campaign, name, version))
            except FileExistsError:
                continue
            return version

    def _folder(self, campaign: str) -> Path:
        return self._campaigns / campaign / "fits"

    def _path(self, campaign: str, name: str, version: int) -> Path:
        return self._folder(campaign) / f"{name}-{version:04d}.json"


@contextmanager
def _store_errors(path: Path) -> Iterator[None]:
    try:
        yield
    except (OSError, ValueError) as error:
        what = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise StoreError(what, part=str(path), todo="free or repair the disk") from error
