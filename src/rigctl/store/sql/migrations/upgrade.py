"""Runs the migrations that a catalogue still lacks, inside the caller's transaction."""

from __future__ import annotations

from pathlib import Path

from alembic import command
from alembic.config import Config
from sqlalchemy import Connection

FIRST = "0001"
"""Catalogues of this version were made before migrations were recorded in them."""


def upgrade(connection: Connection, version: int, to: int) -> None:
    """Bring a catalogue from a version (0: an empty file) to a later one.

    Everything happens in the open transaction of `connection`: a program that dies meanwhile
    leaves the catalogue as it was.
    """
    config = Config()
    # A percent sign in a path would be read as an interpolation.
    config.set_main_option("script_location", str(Path(__file__).parent).replace("%", "%%"))
    config.attributes["connection"] = connection
    if version == 1 and connection.dialect.name == "sqlite":
        command.stamp(config, FIRST)
    command.upgrade(config, f"{to:04d}")
    if connection.dialect.name == "sqlite":
        # Readable at every start without loading Alembic.
        connection.exec_driver_sql(f"PRAGMA user_version = {to}")
