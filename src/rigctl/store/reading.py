"""Looking into a store that another process may own: nothing is written, nothing is locked."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from rigctl.errors import NotFoundError
from rigctl.store.campaigns import Campaigns
from rigctl.store.catalogue import Catalogue
from rigctl.store.edits import Edits
from rigctl.store.folders import ShotFolders
from rigctl.store.imports import Imports
from rigctl.store.integrity.lost import require_no_shots
from rigctl.store.journal import Journal
from rigctl.store.sql.database import Database


@dataclass(frozen=True, slots=True)
class StoreReader:
    """What can be read of a store without owning it."""

    folder: Path
    database: Database
    campaigns: Campaigns
    catalogue: Catalogue
    folders: ShotFolders
    imports: Imports
    edits: Edits
    journal: Journal


@contextmanager
def reading(folder: Path, database: str | None = None) -> Iterator[StoreReader]:
    """Open a store for reading, while a daemon runs on it or none does.

    Parameters
    ----------
    database
        URL of a PostgreSQL database with the catalogue; None: the SQLite file in the folder.

    Raises
    ------
    NotFoundError
        There is no store in this folder.
    StoreError
        The catalogue cannot be read, or a later version of this program wrote it.
    """
    root = folder.absolute()
    catalogue = root / "catalogue.db"
    if database is None and not (catalogue.is_file() and catalogue.stat().st_size):
        require_no_shots(root, str(catalogue))
        raise NotFoundError(
            "holds no catalogue of shots",
            part=str(folder),
            todo="name a campaign folder, or start in the folder the daemon was started in",
        )
    opened = Database(catalogue, address=database, writable=False)
    try:
        yield StoreReader(
            root,
            opened,
            Campaigns(opened),
            Catalogue(opened),
            ShotFolders(root),
            Imports(opened, root),
            Edits(opened),
            Journal(opened),
        )
    finally:
        opened.close()
