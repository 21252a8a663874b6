"""Where compiled functions are kept, and until when.

The compiler's library takes a kept function for fresh while the file that defines it is unchanged.
Compiled functions have those they call, and constants of other files, built in: a fresh one here is
one whose whole room is unchanged.
"""

from __future__ import annotations

from functools import cache
from hashlib import sha256
from pathlib import Path

from numba.core import caching

USES = b"from analysis.compiled import"


@cache
def sources() -> str:
    """Return a digest of every file in a folder of this package where functions are compiled."""
    package = Path(__file__).parent
    folders = {file.parent for file in package.rglob("*.py") if USES in file.read_bytes()}
    digest = sha256()
    for file in sorted(file for folder in folders for file in folder.glob("*.py")):
        digest.update(file.relative_to(package).as_posix().encode() + file.read_bytes())
    return digest.hexdigest()


class BesideSource(caching.InTreeCacheLocator):
    """In `__pycache__`, as long as the sources are what they were."""

    def get_source_stamp(self) -> str:
        """Return what a kept function is fresh by."""
        return sources()


class OfUser(caching.UserWideCacheLocator):
    """In the user's own folder, where the package's cannot be written."""

    def get_source_stamp(self) -> str:
        """Return what a kept function is fresh by."""
        return sources()


LOCATORS = ",".join(f"{__name__}.{kind.__name__}" for kind in (BesideSource, OfUser))
