"""What a fit is made of, wherever it comes from: the poses of a campaign, or its contacts.

Of frames each shot is measured once, and kept on disk by their content. A shot's key covers all
that its numbers depend on: its frames, its set-up, the frames of the shots that teach the method,
the method itself and the sources of the analysis.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from functools import cache
from hashlib import file_digest, sha256
from pathlib import Path
from typing import Protocol

from analysis.campaign import (
    Campaign,
    ShotJob,
    analyse_campaign,
    shows_something_else,
    training_jobs,
)
from analysis.exchange.pose_table import PoseRow
from analysis.exchange.shot_list import ShotRow
from analysis.model.data.gather import pose_data
from analysis.model.data.tables import Data
from analysis.results.impacts import Impacts
from analysis.setup import Setup, SlowErrors, without_exposure
from analysis.shot import AnalysisOptions, Method
from analysis.slow_errors import typical
from rigctl.api.progress import counting
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError
from rigctl.input_errors import as_analysis_errors
from rigctl.measuring.first_analysis import wait_for_compiler
from rigctl.measuring.stored_poses import measured_document, poses_of, slow_errors_of


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """Measured shots.

    Attributes
    ----------
    data
        Poses or contacts of the shots that count.
    refused
        Why each other shot was not measured, by its number.
    now
        How many shots were measured now; of the others the results were there.
    impacts
        Of films of a ball, whose fit has measured them; None: they follow from the data.
    """

    data: Data
    refused: Mapping[int, str] = field(default_factory=dict)
    now: int = 0
    impacts: Impacts | None = None


class Source(Protocol):
    """Where the shots of a campaign come from."""

    @property
    def name(self) -> str:
        """Name of the campaign."""

    def measured(self, workers: int | None) -> Measured:
        """Return the measured shots; measure those that are not.

        Parameters
        ----------
        workers
            Processes; None: one for each processor.

        Raises
        ------
        AnalysisInputError
            No shot can be measured, or a file cannot be read.
        """


OTHER_FILMS = (
    "frames without a set-up are taken for those of two marked spheres of 25.4 mm: of a ball that "
    "bounces state the diameter, ball_diameter_mm=40; of other spheres setup=campaign.toml"
)
VARIABLE = "RIGCTL_CACHE"
"""Environment variable that names another folder."""
LATER_ROOMS = frozenset(
    ("calibration", "effects", "figures", "launch", "model", "qualification", "results")
)
"""Folders of the analysis that work on measured shots: measuring loads none of them."""


def cache_folder() -> Path:
    """Return the user's cache folder of this system."""
    if named := os.environ.get(VARIABLE):
        return Path(named)
    if sys.platform == "win32":
        home = Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local"))
    elif sys.platform == "darwin":
        home = Path.home() / "Library" / "Caches"
    else:
        home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return home / "rigctl"


class KeptShots:
    """Results of shots in a folder, one file each; a file that cannot be read is no result."""

    def __init__(self, folder: Path | None = None) -> None:
        self._folder = (folder or cache_folder()) / "shots"

    def get(self, key: str) -> Json | None:
        """Return the result of a shot; None where there is none."""
        try:
            document: Json = json.loads(self._file(key).read_bytes())
        except (OSError, ValueError):
            return None
        return document

    def put(self, key: str, document: Json) -> None:
        """Keep a result: whole or not at all. A disk that is full or read-only keeps none."""
        file = self._file(key)
        with suppress(OSError):
            file.parent.mkdir(parents=True, exist_ok=True)
            handle, name = tempfile.mkstemp(dir=file.parent, suffix=".part")
            try:
                with os.fdopen(handle, "w", encoding="utf-8") as part:
                    json.dump(document, part, allow_nan=False)
                Path(name).replace(file)
            except BaseException:
                Path(name).unlink(missing_ok=True)
                raise

    def _file(self, key: str) -> Path:
        return self._folder / key[:2] / f"{key}.json"


def shot_keys(jobs: Sequence[ShotJob], method: Method) -> dict[int, str]:
    """Return the key of each shot whose frames can be read, by its number."""
    content = {job.shot: found for job in jobs if (found := digest_of(job.frames)) is not None}
    learned = {} if method == "thesis" else _teaching(jobs, content)
    keys = {}
    for job in jobs:
        if job.shot in content:
            learned_from = learned.get(without_exposure(job.setup))
            about = [sources(), method, asdict(job.setup), content[job.shot], learned_from]
            keys[job.shot] = sha256(json.dumps(about).encode()).hexdigest()
    return keys


def _teaching(jobs: Sequence[ShotJob], content: dict[int, str]) -> dict[Setup, list[object]]:
    """Return what each set-up's spheres are learned from: frames and exposures."""
    return {
        setup: [[content.get(job.shot), job.setup.camera.exposure_s] for job in own]
        for setup, own in training_jobs(jobs).items()
    }


def digest_of(frames: Path) -> str | None:
    """Return the SHA-256 of a file, or of a folder's files by their names; None: not readable."""
    try:
        if frames.is_dir():
            parts = [[file.name, digest_of(file)] for file in sorted(frames.iterdir())]
            return sha256(json.dumps(parts).encode()).hexdigest()
        with frames.open("rb") as file:
            return file_digest(file, "sha256").hexdigest()
    except OSError:
        return None


@cache
def sources() -> str:
    """Return a digest of all source files that measuring depends on."""
    import analysis  # noqa: PLC0415 - only its folder is needed

    package = Path(analysis.__file__).parent
    digest = sha256()
    for file in sorted(package.rglob("*.py")):
        place = file.relative_to(package)
        if place.parts[0] not in LATER_ROOMS:
            digest.update(place.as_posix().encode() + file.read_bytes())
    return digest.hexdigest()


@dataclass(frozen=True, slots=True)
class Frames:
    """A folder of frames with its set-up, or loose frames."""

    campaign: Campaign
    method: Method
    kept: KeptShots = field(default_factory=KeptShots)

    @property
    def name(self) -> str:
        """Name of the campaign."""
        return self.campaign.name

    def measured(self, workers: int | None) -> Measured:
        """Return poses of all shots; those that were measured before are read."""
        with as_analysis_errors():
            keys = shot_keys(self.campaign.jobs, self.method)
            documents = {
                number: document
                for number, key in keys.items()
                if (document := self.kept.get(key)) is not None
            }
            before = len(documents)
            documents |= self._measured_now(keys, documents, workers)
        return self._gathered(documents, now=len(documents) - before)

    def _measured_now(
        self, keys: Mapping[int, str], there: Mapping[int, Json], workers: int | None
    ) -> Iterator[tuple[int, Json]]:
        """Measure what is not there; each shot is kept as soon as it is measured."""
        jobs = self.campaign.jobs
        if len(there) == len(jobs):
            return
        options = AnalysisOptions(method=self.method)
        wait = wait_for_compiler(self.method)
        first = "" if wait is None else f" (compiling first, about {wait}, once)"
        with counting(f"measuring {self.name}{first}") as count:
            done = analyse_campaign(self.campaign, options, workers, count, frozenset(there))
            for job, shot, frames in done:
                document = measured_document(shot)
                if frames and job.shot in keys:
                    self.kept.put(keys[job.shot], document)
                yield job.shot, document

    def _gathered(self, documents: Mapping[int, Json], now: int) -> Measured:
        shots: dict[int, dict[str, list[PoseRow]]] = {}
        errors: list[SlowErrors] = []
        refused: dict[int, str] = {}
        rows = [job.row or ShotRow(job.shot, None, {}, {}) for job in self.campaign.jobs]
        for row in rows:
            document = documents[row.shot]
            if document["status"] != "measured":
                refused[row.shot] = f"{document['step']}: {document['reason']}"
                continue
            slow = slow_errors_of(document["slow_errors"])
            shots[row.shot] = poses_of(document["poses"], slow)
            errors.append(slow)
        counting_shots = set(shots) - {row.shot for row in rows if row.is_excluded}
        setup = typical(next(iter(self.campaign.jobs)).setup, errors)
        data = pose_data(shots, rows, setup) if counting_shots else None
        if data is None or not data.seen.any():
            why = next((f"; shot {shot}: {text}" for shot, text in refused.items()), "")
            todo = OTHER_FILMS if shows_something_else(self.campaign) else None
            raise AnalysisInputError(f"no shot can be measured{why}", part=self.name, todo=todo)
        return Measured(data, refused, now)
