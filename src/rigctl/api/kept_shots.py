"""Measured shots on disk, by the content of their frames: none is measured twice.

A shot's key covers all that its numbers hang on: its frames, its set-up, the frames of the shots
that teach the method, the method itself and the sources of the analysis.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict
from functools import cache
from hashlib import file_digest, sha256
from pathlib import Path
from typing import Any

from analysis.campaign import ShotJob, training_jobs
from analysis.setup import Setup, without_exposure
from analysis.shot import Method

Json = dict[str, Any]

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
