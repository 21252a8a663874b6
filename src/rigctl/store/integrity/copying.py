"""Copies that are proved while they are made: of a file, and of a store while shots are fired."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path

from rigctl.errors import StoreError
from rigctl.progress import Progress
from rigctl.store.durable import FILE_MODE, FOLDER_MODE, create, make_folders
from rigctl.store.integrity.seal import read_seal
from rigctl.store.integrity.verifying import Verified, verify_store
from rigctl.store.orders import Orders
from rigctl.store.reading import StoreReader, reading
from rigctl.store.records import ShotRecord
from rigctl.store.sweeps import Sweeps

_CHUNK = 1 << 20


def copy_synced(source: Path, target: Path) -> str:
    """Copy a file to where none is, force it to disk, and return the SHA-256 of its content.

    Folders above the target are made.

    Raises
    ------
    OSError
        It cannot be read or written.
    """
    make_folders(target.parent)
    digest = hashlib.sha256()
    with source.open("rb") as read, create(target) as write:
        while chunk := read.read(_CHUNK):
            digest.update(chunk)
            write.write(chunk)
        write.flush()
        os.fsync(write.fileno())
    return digest.hexdigest()


_BESIDE = ("estop.json", "keys.json")
"""Files beside the catalogue that must outlive it: a latch stays a latch, a key opens the same."""


@dataclass(frozen=True, slots=True)
class Backup:
    """What was copied, and how its verification went."""

    shots: int
    files: int


def back_up(store: StoreReader, target: Path, progress: Progress) -> Backup:
    """Copy a store into an empty folder, and verify the copy.

    The catalogue is copied first, at one moment; the folder of a shot is complete before its row
    has that state, and never changes. Later shots and results are not in the copy. The store's
    identity is copied too: the key of the audit, and the named keys that it hashes. All of
    it is for its owner alone.

    Raises
    ------
    StoreError
        The copy differs from what was stored; the first faults are named.
    OSError
        The disk refused.
    """
    progress("copying the catalogue", 0.0)
    target.chmod(FOLDER_MODE)
    store.database.copy_to(target / "catalogue.db")
    (target / "catalogue.db").chmod(FILE_MODE)
    if (seal := read_seal(store.folder)) is not None:
        seal.keep(target)
    for name in _BESIDE:
        if (store.folder / name).exists():
            copy_synced(store.folder / name, target / name)
    with reading(target) as copy:
        total = max(copy.catalogue.count(), 1)
        files = 0
        for done, shot in enumerate(copy.catalogue.each()):
            progress(f"copying shot {shot.id}", 0.5 * done / total)
            files += _copy_shot(store, copy, shot)
        files += _copy_rest(store, copy)
        found = verify_store(copy, lambda text, share: progress(text, 0.5 + 0.5 * (share or 0.0)))
        _require_whole(found)
    return Backup(found.shots, files)


def _copy_shot(store: StoreReader, copy: StoreReader, shot: ShotRecord) -> int:
    source, target = store.folders.folder(shot.id), copy.folders.folder(shot.id)
    if not source.is_dir():
        return _copy_order(store, copy, shot.id)
    there = store.folders.results(shot.id)
    later = {path.name for number, path in there.items() if number > shot.results}
    files = [path for path in source.rglob("*") if path.is_file() and path.name not in later]
    for path in files:
        if not path.name.startswith("."):
            copy_synced(path, target / path.relative_to(source))
    return len(files)


def _copy_order(store: StoreReader, copy: StoreReader, shot: str) -> int:
    """Copy the order of a shot that has not ended, as a copy without catalogue would need it."""
    try:
        copy_synced(Orders(store.folders).path(shot), Orders(copy.folders).path(shot))
    except FileNotFoundError:
        # The shot has ended meanwhile; its manifest has the same content.
        return 0
    return 1


def _copy_rest(store: StoreReader, copy: StoreReader) -> int:
    """Copy what belongs to no single shot: imported tables, saved fits, orders of sweeps."""
    pairs = [(store.folder / "campaigns", copy.folder / "campaigns")]
    for number in copy.imports.numbers():
        source, target = store.imports.folder(number), copy.imports.folder(number)
        pairs.append((source / "folder", target / "folder"))
        copy_synced(source / "import.json", target / "import.json")
    files = 0
    for source, target in pairs:
        for path in source.rglob("*"):
            if path.is_file() and not path.name.startswith("."):
                copy_synced(path, target / path.relative_to(source))
                files += 1
    for target_file in Sweeps(copy.database, copy.folder).files():
        path = store.folder / target_file.relative_to(copy.folder)
        # Sweeps of earlier versions have no files.
        if path.is_file():
            copy_synced(path, target_file)
            files += 1
    return files + len(pairs) - 1


def _require_whole(found: Verified) -> None:
    if found.faults:
        named = "; ".join(f"{fault.part} {fault.what}" for fault in found.faults[:3])
        raise StoreError(
            f"the copy is not what was stored: {named}",
            value=f"{len(found.faults)} faults",
            todo="verify the store itself with rigctl verify",
        )
