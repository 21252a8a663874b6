"""The folder of the user's own effects as the daemon sees it: files, which only jobs run.

A file that breaks, hangs or ends its process then takes no more with it than the job that read it.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from rigctl.config import Configuration
from rigctl.documents import Json
from rigctl.errors import ConfigurationError
from rigctl.model.known_effects import available, effect_named
from rigctl.progress import Progress

PART = "analysis.effects"


@dataclass(frozen=True, slots=True)
class OwnEffects:
    """The folder that the configuration names; None where it names none."""

    folder: Path | None

    @classmethod
    def of(cls, configuration: Configuration) -> Self:
        """Return the folder of a configuration."""
        named = configuration.analysis.effects
        return cls(None if named is None else Path(named).expanduser())

    def check(self) -> None:
        """Raise `ConfigurationError` where what is named is no folder."""
        if self.folder is not None and not self.folder.is_dir():
            raise ConfigurationError(
                "is no folder",
                part=PART,
                value=repr(str(self.folder)),
                todo="make it, or name the folder with the files of your effects",
            )

    def require(self, names: Iterable[str]) -> None:
        """Raise `NotFoundError` for a name that no effect has.

        Which names the files of the folder give is known to those alone who run them: where there
        are files, the job refuses.
        """
        if not self._files():
            for name in names:
                effect_named(name)

    def asked(self) -> Json:
        """Return the arguments of a job, so that its effects are those of the folder as well."""
        return {"own": str(self.folder)} if self._files() else {}

    def fingerprint(self) -> Hashable:
        """Return what changes whenever a file in the folder changes."""
        return tuple(
            (path.name, about.st_mtime_ns, about.st_size)
            for path in self._files()
            if (about := path.stat())
        )

    def _files(self) -> list[Path]:
        return [] if self.folder is None else sorted(self.folder.glob("*.py"))


def reading_job(asked: Json, progress: Progress) -> Json:
    """Read the folder `own` and return what its effects say of themselves, and their faults."""
    progress("reading the effects", None)
    known = available(Path(asked["own"]), PART)
    faults = [fault.to_json() for fault in known.faults]
    return {"folder": asked["own"], "effects": known.own(), "faults": faults}
