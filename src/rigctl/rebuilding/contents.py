"""Contents of a store's folder without a catalogue: shots fired here, and imported campaigns."""

from __future__ import annotations

import json
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from analysis.exchange.shot_list import ShotRow
from rigctl.documents import Json
from rigctl.errors import RefusedError
from rigctl.exchange.importing import shot_of_row
from rigctl.settings import ShotSettings
from rigctl.store.folders import ShotFolders, results_in, sha256
from rigctl.store.imports import LISTING, ImportedShot, Stage
from rigctl.store.integrity.anchors import anchor_of
from rigctl.store.integrity.ledger import Anchor
from rigctl.store.records import Request
from rigctl.store.states import Fired, ShotState

UNKNOWN_ACTOR = "not known"
"""Actor of a shot whose manifest does not name one."""

_STORED: Json = {"state": ShotState.STORED, "fired": Fired.YES}
"""The end of every shot whose manifest is older than its entry `outcome`."""


@dataclass(frozen=True, slots=True)
class FiredShot:
    """A shot as its row in the catalogue will be.

    Attributes
    ----------
    row
        Columns of the table of shots.
    request
        None: the manifest is older than its entry `request`.
    digests
        SHA-256 of the file of each result, by its number.
    anchor
        Head of the audit when the manifest was written; None: it is older, or an order.
    """

    row: dict[str, object]
    request: Request | None
    digests: dict[int, str]
    anchor: Anchor | None = None

    @property
    def number(self) -> int:
        """The number of the shot."""
        return int(str(self.row["number"]))


def from_manifest(folders: ShotFolders, shot: str) -> FiredShot:
    """Return a shot that has ended; raise `RigError`, `ValueError`, `KeyError` or `TypeError`."""
    manifest = folders.manifest(shot)
    outcome = manifest.get("outcome") or _STORED
    results = folders.results(shot)
    state = ShotState(outcome["state"])
    failure, code = outcome.get("failure"), outcome.get("failure_code")
    if state is ShotState.STORED and results:
        latest: Json = json.loads(results[max(results)].read_bytes())
        state = ShotState.ANALYSED
        if latest.get("status") == "refused":
            state, failure, code = ShotState.REFUSED, latest.get("reason"), RefusedError.code
    frames = manifest["frames"]
    row = {
        **_ordered(manifest),
        "state": state,
        "outcome": ShotState(outcome["state"]),
        "fired": Fired(outcome["fired"]),
        "fired_at": manifest.get("fired_at"),
        "ended_at": outcome.get("ended_at"),
        "frames": frames and frames["shape"][0],
        "lost": frames and len(frames["lost"]),
        "failure": failure,
        "failure_code": code,
        "results": max(results, default=0),
        "manifest": folders.digest(shot),
    }
    digests = {number: sha256(path) for number, path in results.items()}
    return FiredShot(row, _request(manifest), digests, anchor_of(manifest))


def from_order(order: Json) -> FiredShot:
    """Return a shot that has not ended: whether it fired is unknown, and a person has to look."""
    standing = {"state": ShotState.FIRING, "outcome": None, "fired": Fired.UNKNOWN, "results": 0}
    return FiredShot({**_ordered(order), **standing}, _request(order), {})


def names(day: Path) -> list[str]:
    """Return the names of the shots whose folders lie in the folder of a day."""
    return sorted(path.name for path in day.iterdir() if path.is_dir() and path.name[0] != ".")


def _ordered(document: Json) -> dict[str, object]:
    return {
        "number": int(document["number"]),
        "id": str(document["shot"]),
        "settings": ShotSettings.model_validate(document["settings"]).model_dump_json(),
        "campaign": document["campaign"],
        "note": document["note"],
        "actor": (document.get("request") or {}).get("actor") or UNKNOWN_ACTOR,
        "simulated": int(document["simulated"]),
        "configuration": document["configuration"]["sha256"],
        "accepted_at": document["accepted_at"],
    }


def _request(document: Json) -> Request | None:
    stated = document.get("request") or {}
    if stated.get("key") is None:
        return None
    return Request(str(stated["key"]), str(stated["body_sha256"]))


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
