"""The source of the trigger box's firmware: which files, and their digest."""

from __future__ import annotations

import hashlib
from pathlib import Path

from rigctl.shipped import shipped

SOURCES = ("trigger_box.c", "trigger_box.h", "atmega328p.c")
"""What the board runs; the rest builds it and tests it."""


def source_folder() -> Path:
    """Return the folder of the firmware's source; raise `ConfigurationError` if it is not there."""
    return shipped("firmware", "firmware", todo="install the package again")


def source_digest() -> str:
    """Return the SHA-256 of the source that the board runs, as `rigctl firmware` prints it."""
    source = source_folder()
    return hashlib.sha256(b"".join((source / name).read_bytes() for name in SOURCES)).hexdigest()
