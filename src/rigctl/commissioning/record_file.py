"""The signed record of a commissioning in a file, and the check of its signature."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rigctl.commissioning.answers import signature
from rigctl.errors import SettingsError, StoreError
from rigctl.store.integrity.seal import read_seal


def write_record(path: Path, document: Mapping[str, Any]) -> None:
    """Write a record; raise `StoreError` if the disk refuses."""
    try:
        path.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    except OSError as error:
        raise StoreError(
            f"the record cannot be written: {error.strerror}",
            part=str(path),
            todo="name a file that can be written",
        ) from error


def read_record(path: Path, store: Path) -> tuple[dict[str, Any], str, str]:
    """Return a record without its signature, that signature, and the one the store would give.

    Raises
    ------
    SettingsError
        The file is no record.
    StoreError
        The store's key is missing or cannot be read.
    """
    try:
        document = dict(json.loads(path.read_text(encoding="utf-8")))
        given = str(document.pop("signature"))
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise SettingsError(
            f"is no record of a commissioning: {error}", part=str(path), todo="name another file"
        ) from error
    seal = read_seal(store)
    if seal is None:
        raise StoreError("the key of the audit is missing", part=str(store), todo="name the store")
    return document, given, signature(seal, document)
