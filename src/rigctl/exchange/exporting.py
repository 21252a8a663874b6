"""A campaign of the catalogue becomes an exchange folder, whole or not at all."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rigctl.documents import Json
from rigctl.errors import NotFoundError, StoreError
from rigctl.exchange.amending import amended
from rigctl.exchange.fresh import fresh_folder
from rigctl.exchange.remarks import REMARKS, parsed, written
from rigctl.progress import Progress
from rigctl.store import ShotRecord, Store, StoreReader
from rigctl.store.campaign_remarks import Remarks
from rigctl.store.durable import write_synced
from rigctl.store.folders import sha256
from rigctl.store.imports import LISTING
from rigctl.store.integrity.copying import copy_synced

ALL = 10_000_000
SHOT_LIST = "shots.csv"


@dataclass(frozen=True, slots=True)
class Exported:
    """A folder that was written: how many shots it holds, and how many without frames it lacks."""

    campaign: str
    folder: Path
    shots: int
    left_out: int


def export_campaign(
    store: Store | StoreReader, campaign: str, folder: Path, *, progress: Progress
) -> Exported:
    """Write a campaign as an exchange folder.

    One that was imported comes out as it went in, byte for byte; where shots were excluded, noted
    or tagged since, these columns of shots.csv alone are changed, and where the campaign was noted
    or tagged since, remarks.toml.

    Raises
    ------
    NotFoundError
        There is no such campaign, or none of its shots has frames.
    AnalysisInputError
        Its shots differ in camera, spheres or surroundings.
    SettingsError
        The folder is there already.
    StoreError
        The disk refuses, or what is stored is not what was stored; nothing is written.
    """
    record = store.campaigns.one(campaign)
    remarks = Remarks(record.note, record.tags)
    shots = store.catalogue.shots(campaign=campaign, limit=ALL)
    try:
        home, digest = store.imports.of(campaign)
    except NotFoundError:
        kept = [shot for shot in shots if shot.frames is not None]
        if not kept:
            raise NotFoundError("has no frames to export", part=f"campaign {campaign}") from None
        # The daemon starts without the analysis.
        from rigctl.exchange.fired import write_fired  # noqa: PLC0415

        with fresh_folder(folder) as partial:
            write_fired(partial, campaign, kept, store.folders, progress)
            _remark(partial, written(remarks))
        return Exported(campaign, folder, len(kept), len(shots) - len(kept))
    with fresh_folder(folder) as partial:
        files = listing(home, digest)
        _copy_back(home, files, partial, shots, progress)
        _remark(partial, _remarks_of(home, files, remarks))
    return Exported(campaign, folder, len(shots), 0)


def _copy_back(
    home: Path,
    files: Mapping[str, Json],
    folder: Path,
    shots: Sequence[ShotRecord],
    progress: Progress,
) -> None:
    for done, (name, about) in enumerate(files.items()):
        progress(f"writing {name}", done / len(files))
        if name in {SHOT_LIST, REMARKS}:
            continue
        if copy_synced(home / about["kept"], folder / name) != about["sha256"]:
            raise _altered(home / about["kept"])
    by_number = {shot.imported_as: shot for shot in shots if shot.imported_as is not None}
    content = amended(_kept(home, files[SHOT_LIST]), by_number)
    write_synced(folder / SHOT_LIST, lambda file: file.write(content))


def _remarks_of(home: Path, files: Mapping[str, Json], remarks: Remarks) -> bytes | None:
    """Return the file of remarks as imported, or a new one if they changed; None without any."""
    if REMARKS in files and parsed(content := _kept(home, files[REMARKS])) == remarks:
        return content
    return written(remarks)


def _remark(folder: Path, content: bytes | None) -> None:
    if content is not None:
        write_synced(folder / REMARKS, lambda file: file.write(content))


def _kept(home: Path, about: Json) -> bytes:
    path: Path = home / about["kept"]
    if sha256(path) != about["sha256"]:
        raise _altered(path)
    return path.read_bytes()


def listing(home: Path, digest: str) -> dict[str, Json]:
    """Return the files of an imported folder by name: where each is kept, and its digest.

    Raises
    ------
    StoreError
        The list is not the one that was stored.
    """
    path = home / LISTING
    if sha256(path) != digest:
        raise _altered(path)
    files: dict[str, Json] = json.loads(path.read_bytes())["files"]
    return files


def _altered(path: Path) -> StoreError:
    return StoreError(
        "is not the file that was imported", part=str(path), todo="restore it from a backup"
    )
