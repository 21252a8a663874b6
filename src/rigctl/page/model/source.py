"""Where a model's shots come from: a campaign of the store, or a folder such as a challenge's."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import quote

from rigctl.daemon import Daemon
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError
from rigctl.jobs import Job, in_process
from rigctl.measuring.measured import measured_files, request
from rigctl.model import FUNCTIONS
from rigctl.model.own_effects import OwnEffects
from rigctl.store import ShotRecord

LOOKED_AT = ("campaign.toml", "shots.csv", "poses.csv", "contacts.csv", "impacts.csv")


@dataclass(frozen=True, slots=True)
class Source:
    """Shots to be fitted; `folder` is None for a campaign of the store."""

    daemon: Daemon = field(repr=False)
    title: str
    folder: Path | None = None

    @classmethod
    def of_folder(cls, daemon: Daemon, path: str) -> Source:
        """Return a campaign's folder as a source.

        Raises
        ------
        AnalysisInputError
            No campaign lies there.
        """
        folder = Path(path).expanduser().absolute()
        if not (folder / LOOKED_AT[0]).is_file():
            raise AnalysisInputError(
                f"is no campaign's folder, as it has no {LOOKED_AT[0]}",
                part=path,
                todo="name a folder that `rigctl challenge new` or `rigctl analyse --out` wrote",
            )
        return cls(daemon, folder.name, folder)

    @property
    def address(self) -> str:
        """Where the page of its model is."""
        if self.folder is None:
            return f"/model/{self.title}"
        return f"/model?folder={quote(str(self.folder))}"

    def elsewhere(self, command: str) -> str | None:
        """Say where further shots are for, where this rig adds none to these; None where it does.

        Parameters
        ----------
        command
            What writes the shots as a sweep file.
        """
        told = f"for the rig that fired this campaign: {command} writes them as a sweep file."
        if self.folder is not None:
            return told
        if not self.daemon.store.is_imported(self.title):
            return None
        return f"{told} This rig adds none to an imported campaign; it fires under another name."

    def without_its_folder(self, text: str) -> str:
        """Return a text with the names of files in place of where they lie on this computer."""
        return text if self.folder is None else text.replace(f"{self.folder}/", "")

    def seen_as(self, effects: Sequence[str], view: str) -> str:
        """Return where the page of its model stands with these effects, in this view."""
        more = f"effects={quote(','.join(effects))}&view={view}"
        return f"{self.address}{'?' if self.folder is None else '&'}{more}"

    def ask(self, kind: str, effects: Sequence[str] = (), **more: object) -> Job:
        """Return the job that answers a question about these shots as they are measured now.

        Parameters
        ----------
        kind
            Name of a function of `rigctl.model.computing`, without `_job`.
        effects
            Added to the base model, in their order.
        more
            What the function asks for besides.

        Raises
        ------
        NotFoundError
            No effect has that name, or no shot is measured.
        JobsFullError
            Too many jobs wait.
        """
        own = OwnEffects.of(self.daemon.configuration)
        own.require(effects)
        asked, shots = self._asked(effects)
        named = (kind, self.title, *effects, repr(more), shots, own.fingerprint())
        work = in_process(f"{FUNCTIONS}:{kind}_job", {**asked, **own.asked(), **more})
        return self.daemon.jobs.submit(kind, self.title, work, named, folder=self._lies_in)

    def asked_before(self, kind: str) -> list[Job]:
        """Return the jobs that answered such a question about these shots, the latest first.

        A campaign that bears the same name elsewhere is another one.
        """
        these = (kind, self.title, self._lies_in)
        return [
            job
            for job in reversed(self.daemon.jobs.jobs())
            if (job.kind, job.subject, job.folder) == these and job.result is not None
        ]

    @property
    def _lies_in(self) -> str:
        return "" if self.folder is None else str(self.folder)

    def stored(self, number: int) -> ShotRecord | None:
        """Return a shot of the store by its number; None where the shots are of a folder."""
        if self.folder is not None:
            return None
        store = self.daemon.store
        found = store.shots(campaign=self.title, limit=store.campaigns.one(self.title).shots)
        return next((shot for shot in found if shot.number == number), None)

    def _asked(self, effects: Sequence[str]) -> tuple[Json, Hashable]:
        """Return the question, and what changes when the shots do."""
        if self.folder is None:
            files = measured_files(self.daemon.store, self.title)
            return request(self.title, files, effects, self.daemon.store), tuple(files)
        there = [path for name in LOOKED_AT if (path := self.folder / name).exists()]
        stands = tuple((path.name, path.stat().st_mtime_ns) for path in there)
        asked = request(self.title, [], effects)
        return {**asked, "folder": str(self.folder)}, (str(self.folder), stands)
