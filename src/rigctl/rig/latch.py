"""The latch of the emergency stop, and the file in which it outlives the process."""

from __future__ import annotations

import json
import logging
from dataclasses import asdict, dataclass
from pathlib import Path

from rigctl.errors import RefusedError
from rigctl.store.durable import sync_folder, write_synced

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Latch:
    """Why the rig is stopped: who stopped it, why, and when (UTC, ISO 8601)."""

    actor: str
    reason: str
    at: str


class LatchFile:
    """A file beside the catalogue, so a full or locked catalogue cannot lose the latch."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def read(self) -> Latch | None:
        """Return the latch; a file that cannot be read counts as one."""
        try:
            return Latch(**json.loads(self._path.read_text(encoding="utf-8")))
        except FileNotFoundError:
            return None
        except (OSError, ValueError, TypeError) as error:
            return Latch("rig", f"the latch file cannot be read: {error}", "")

    def keep(self, latch: Latch) -> None:
        """Force the latch to disk; where the disk refuses it holds in memory, and the log says so.

        Never raises.
        """
        partial = self._path.with_suffix(".partial")
        try:
            partial.unlink(missing_ok=True)
            write_synced(partial, lambda file: file.write(json.dumps(asdict(latch)).encode()))
            partial.replace(self._path)
            sync_folder(self._path.parent)
        except OSError:
            _log.exception("the latch holds in memory only")

    def forget(self) -> None:
        """Remove the file.

        Raises
        ------
        RefusedError
            The disk does not let it go, so a restart would find it again.
        """
        try:
            self._path.unlink(missing_ok=True)
            sync_folder(self._path.parent)
        except OSError as error:
            raise RefusedError(
                f"the latch file cannot be removed: {error.strerror}",
                part=str(self._path),
                todo="correct the folder's rights, then release again",
            ) from error
