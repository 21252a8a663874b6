"""Imported campaigns, from the lists of their files and the manifests of their shots."""

from __future__ import annotations

import json
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from analysis.exchange.shot_list import ShotRow
from rigctl.documents import Json
from rigctl.exchange.importing import shot_of_row
from rigctl.store.folders import results_in, sha256
from rigctl.store.imports import LISTING, ImportedShot, Stage


@dataclass(frozen=True, slots=True)
class ImportedCampaign:
    """An import as its rows in the catalogue will be.

    Attributes
    ----------
    stage
        Where its files are, and the number of the import.
    digest
        SHA-256 of the list of its files.
    at
        When that list was written, the time of the import.
    later
        For each shot the SHA-256 of results beyond the first, by their numbers.
    """

    stage: Stage
    campaign: str
    digest: str
    at: datetime
    shots: list[ImportedShot]
    later: list[dict[int, str]]


def from_folder(home: Path) -> ImportedCampaign:
    """Return the campaign of an import; raise `OSError`, `ValueError`, `KeyError`, `TypeError`."""
    listing = home / LISTING
    about: Json = json.loads(listing.read_bytes())
    manifests = sorted(home.glob("i*/manifest.json"))
    return ImportedCampaign(
        stage=Stage(int(home.name[1:]), home),
        campaign=str(about["campaign"]),
        digest=sha256(listing),
        at=datetime.fromtimestamp(listing.stat().st_mtime, UTC),
        shots=[_shot(path) for path in manifests],
        later=[_later(path.parent) for path in manifests],
    )


def _shot(path: Path) -> ImportedShot:
    manifest: Json = json.loads(path.read_bytes())
    fired_at, frames = manifest["fired_at"], manifest["frames"]
    time = None if fired_at is None else datetime.fromisoformat(fired_at)
    row = ShotRow(manifest["number"], time, manifest["settings"], manifest["words"])
    measured = (path.parent / "result-0001.json").exists()
    return shot_of_row(row, frames and int(frames["shape"][0]), measured=measured)


def _later(home: Path) -> dict[int, str]:
    found = results_in(home)
    return {number: sha256(path) for number, path in found.items() if number > 1}
