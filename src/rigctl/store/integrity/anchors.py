"""Heads of the ledger in a file of the user's, far from the store: what was cut off is found."""

from __future__ import annotations

import json
import os
from dataclasses import asdict
from pathlib import Path

from rigctl.errors import SettingsError, StoreError
from rigctl.store.integrity.ledger import Anchor


def read_anchors(path: Path) -> list[Anchor]:
    """Return the heads in a file, oldest first; none where it is not there.

    Raises
    ------
    SettingsError
        It cannot be read, or is no such file.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
        return [_anchor(json.loads(line)) for line in lines]
    except FileNotFoundError:
        return []
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise SettingsError(
            f"is no file of anchors: {error}", part=str(path), todo="name another file"
        ) from error


def add_anchor(path: Path, anchor: Anchor) -> None:
    """Append a head to a file and force it to disk.

    Raises
    ------
    StoreError
        The disk refused.
    """
    try:
        with path.open("a", encoding="utf-8") as file:
            file.write(f"{json.dumps(asdict(anchor))}\n")
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        raise StoreError(
            f"the anchor cannot be written: {error.strerror}",
            part=str(path),
            todo="name a file that can be written",
        ) from error


def anchor_of(manifest: object) -> Anchor | None:
    """Return the head that a manifest holds; None in one of an earlier version."""
    held = manifest.get("audit") if isinstance(manifest, dict) else None
    try:
        return None if held is None else _anchor(held)
    except (KeyError, TypeError, ValueError):
        return None


def _anchor(document: dict[str, object]) -> Anchor:
    return Anchor(int(str(document["entry"])), str(document["digest"]))
