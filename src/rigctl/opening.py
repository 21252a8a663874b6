"""The store that a configuration means."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path

from rigctl.config import Configuration, load
from rigctl.store import Store, StoreReader, reading


def own_store(configuration: Configuration, *, shared: bool = False) -> Store:
    """Open the store of a configuration to write; raise as `Store`."""
    section = configuration.store
    return Store(Path(section.folder), database=section.database, shared=shared)


def read_store(path: Path | None) -> AbstractContextManager[StoreReader]:
    """Open the store of a configuration's file to read; None: the simulated rig's.

    Raises
    ------
    ConfigurationError
        The configuration cannot be.
    NotFoundError, StoreError
        As `reading`, when the block begins.
    """
    section = load(path).store
    return reading(Path(section.folder), section.database)
