"""A folder that is there whole, or not at all."""

from __future__ import annotations

import shutil
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rigctl.errors import SettingsError, StoreError
from rigctl.store.durable import sync_folder


@contextmanager
def fresh_folder(target: Path) -> Iterator[Path]:
    """Give an empty folder that takes the place of `target` once the block has ended well.

    Raises
    ------
    SettingsError
        Something is there already.
    StoreError
        The disk refused; nothing is left behind.
    """
    target = target.absolute()
    if target.exists() and not (target.is_dir() and not any(target.iterdir())):
        raise SettingsError(
            "is there already", part=str(target), todo="name a folder that is not there"
        )
    partial = target.with_name(f".{target.name}.{uuid.uuid4().hex}.partial")
    try:
        partial.mkdir(parents=True)
        yield partial
        for path in (*(each for each in partial.rglob("*") if each.is_dir()), partial):
            sync_folder(path)
        partial.rename(target)
        sync_folder(target.parent)
    except OSError as error:
        raise StoreError(
            f"nothing was written: {error.strerror or error}",
            part=str(target),
            todo="free or repair the disk, or name another folder",
        ) from error
    finally:
        shutil.rmtree(partial, ignore_errors=True)
