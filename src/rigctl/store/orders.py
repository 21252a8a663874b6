"""Orders of shots on disk beside the shots: who, by which request, with which settings.

::

    shots/20260131/.20260131-000042.order.json    from the order to the end of the shot

The manifest of a shot that has ended has the same and more. With both the catalogue can be built
again, and no idempotency key is lost with it.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rigctl.errors import StoreError
from rigctl.store.durable import replace_synced
from rigctl.store.folders import ShotFolders
from rigctl.store.records import Request, ShotRecord

FORMAT = 1
_ENDING = ".order.json"


class Orders:
    """The orders of shots that have not ended."""

    def __init__(self, folders: ShotFolders) -> None:
        self._folders = folders

    def keep(self, shot: ShotRecord, request: Request) -> None:
        """Write the order of an accepted shot; one that is there was never acknowledged.

        Raises
        ------
        StoreError
            The disk refused.
        """
        path = self.path(shot.id)
        text = json.dumps(order_document(shot, request), allow_nan=False, indent=1).encode()
        try:
            replace_synced(path, text)
        except OSError as error:
            raise StoreError(
                f"the order of the shot cannot be written: {error.strerror}",
                part=str(path),
                todo="free or repair the disk, then try again",
            ) from error

    def has(self, shot: str) -> bool:
        """Whether the order of a shot is there."""
        return self.path(shot).exists()

    def forget(self, shot: str) -> None:
        """Remove the order of a shot whose manifest is there; raise `OSError` if it stays."""
        self.path(shot).unlink(missing_ok=True)

    def all(self) -> Iterator[str]:
        """Give the names of the shots whose orders are there."""
        for day in self._folders.days():
            for entry in os.scandir(day):
                if entry.name.endswith(_ENDING):
                    yield entry.name.removeprefix(".").removesuffix(_ENDING)

    def read(self, shot: str) -> dict[str, Any]:
        """Return an order; raise `OSError` or `ValueError` where it cannot be read."""
        document: dict[str, Any] = json.loads(self.path(shot).read_bytes())
        return document

    def path(self, shot: str) -> Path:
        """Return where the order of a shot lies as long as it has not ended."""
        return self._folders.folder(shot).with_name(f".{shot}{_ENDING}")


def order_document(shot: ShotRecord, request: Request | None) -> dict[str, Any]:
    """Return the fields of a shot that its order and its manifest share."""
    return {
        "format": FORMAT,
        "shot": shot.id,
        "number": shot.number,
        "campaign": shot.campaign,
        "note": shot.note,
        "accepted_at": shot.accepted_at.isoformat(),
        "settings": shot.ordered.model_dump(mode="json"),
        "simulated": shot.simulated,
        "configuration": {"sha256": shot.configuration},
        "request": {
            "actor": shot.actor,
            "key": None if request is None else request.key,
            "body_sha256": None if request is None else request.body_hash,
        },
    }


def outcome_document(shot: ShotRecord) -> dict[str, Any]:
    """Return the fields of a manifest on the end of its shot."""
    return {
        "state": str(shot.outcome),
        "fired": str(shot.fired),
        "ended_at": None if shot.ended_at is None else shot.ended_at.isoformat(),
        "failure": shot.failure,
        "failure_code": shot.failure_code,
    }
