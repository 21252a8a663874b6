"""What a report is about: the data of a campaign, where it came from, and what is not in it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from analysis.campaign import DESCRIPTION, FRAMES, SHOT_LIST
from analysis.exchange.shot_list import EXCLUDED, ShotRow, read_shot_list
from analysis.files import read_toml
from analysis.model.data.gather import CONTACTS, IMPACTS, POSES, gather
from analysis.model.data.tables import Data
from analysis.results.impacts import LeftOut
from analysis.setup import setup_document
from rigctl.config import load
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError
from rigctl.input_errors import as_analysis_errors
from rigctl.measuring.measured import MOST_SHOTS, MeasuredFiles, measured_files
from rigctl.measuring.stored_shot import manifest_setup
from rigctl.model.campaigns import poses_from
from rigctl.store import ShotRecord, ShotState, Store, StoreReader, reading


@dataclass(frozen=True, slots=True)
class Facts:
    """Facts under one heading: name, with its unit, and value."""

    heading: str
    rows: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Source:
    """A campaign as a report needs it.

    Attributes
    ----------
    title
        Of the campaign.
    origin
        What the commands of this program call it: its name, or its folder.
    stored
        Whether it is in a catalogue.
    data
        Poses, or tabulated contacts.
    simulated
        Whether its shots were fired in simulation; None: nobody wrote it down.
    facts
        Apparatus and settings.
    listed
        How many shots there are, measured or not.
    missing
        Shots without a measurement that counts, and why.
    files
        Path and SHA-256 of all that was read, or that lies behind it.
    fired
        When each shot was fired, by its number, where that was noted.
    """

    title: str
    origin: str
    stored: bool
    data: Data
    simulated: bool | None
    facts: tuple[Facts, ...]
    listed: int
    missing: tuple[LeftOut, ...]
    files: tuple[tuple[str, str], ...]
    fired: Mapping[int, datetime]


def open_source(campaign: Path, configuration: Path | None) -> Source:
    """Open a campaign's folder, or the campaign of that name in the catalogue."""
    if campaign.exists() or len(campaign.parts) != 1:
        return folder_source(campaign)
    with reading(Path(load(configuration).store.folder)) as store:
        return stored_source(store, str(campaign))


def folder_source(folder: Path) -> Source:
    """Read a campaign's folder.

    Raises
    ------
    AnalysisInputError
        It cannot be read.
    """
    home = folder.parent if folder.is_file() else folder
    with as_analysis_errors():
        title, data = gather(folder)
        rows = read_shot_list(home / SHOT_LIST)
        described = read_toml(home / DESCRIPTION)
    try:
        hashes = _hashes(home)
    except OSError as error:
        raise AnalysisInputError(f"cannot be read: {error}", part=str(folder)) from error
    settings = _ranges([row.numbers for row in rows])
    return Source(
        title=title,
        origin=str(folder),
        stored=False,
        data=data,
        simulated=None,
        facts=(*_facts(described, "campaign"), Facts("settings", settings)),
        listed=len(rows),
        missing=_unmeasured(rows, data),
        files=hashes,
        fired={row.shot: _utc(row.time) for row in rows if row.time is not None},
    )


def _hashes(home: Path) -> tuple[tuple[str, str], ...]:
    """Return the files of a campaign's folder with their hashes."""
    named = [home / name for name in (DESCRIPTION, SHOT_LIST, POSES, CONTACTS, IMPACTS)]
    frames = sorted((home / FRAMES).rglob("*"))
    return tuple(
        (path.relative_to(home).as_posix(), _sha256(path))
        for path in (*named, *frames)
        if path.is_file()
    )


def _unmeasured(rows: Sequence[ShotRow], data: Data) -> tuple[LeftOut, ...]:
    known = {*map(int, data.shots), *data.unusable}
    return tuple(
        LeftOut(row.shot, _excluded(row.words.get(EXCLUDED)))
        if row.is_excluded
        else LeftOut(row.shot, "no measurement of it; `rigctl analyse` says why")
        for row in rows
        if row.is_excluded or row.shot not in known
    )


def stored_source(store: Store | StoreReader, name: str) -> Source:
    """Read a campaign of the catalogue.

    Raises
    ------
    NotFoundError
        There is no such campaign, or none of its shots is measured.
    AnalysisInputError
        A stored file cannot be read, or two shots were fired under different set-ups.
    """
    measured = measured_files(store, name)
    data = poses_from(name, measured)
    shots = store.catalogue.shots(campaign=name, limit=MOST_SHOTS)
    manifests = [_json(own.manifest) for own in measured]
    files = [
        entry
        for own, manifest in zip(measured, manifests, strict=True)
        for entry in _behind(own, manifest)
    ]
    first = manifests[0]
    about = setup_document(manifest_setup(first))
    if "kind" in first.get("camera", {}):
        about["recorder"] = first["camera"]
    return Source(
        title=name,
        origin=name,
        stored=True,
        data=data,
        simulated=any(shot.simulated for shot in shots),
        facts=(
            *_facts({**first.get("configuration", {}), **about}, "configuration"),
            Facts("settings", _ranges([_numbers(m["settings"]) for m in manifests])),
            Facts("when and by what", _when(shots, manifests)),
        ),
        listed=len(shots),
        missing=tuple(
            LeftOut(shot.number if shot.imported_as is None else shot.imported_as, why)
            for shot in shots
            if (why := _why_missing(shot)) is not None
        ),
        files=tuple(files),
        fired={
            int(m["number"]): _utc(datetime.fromisoformat(m["fired_at"]))
            for m in manifests
            if m["fired_at"] is not None
        },
    )


def _behind(files: MeasuredFiles, manifest: Json) -> list[tuple[str, str]]:
    """Return the files of a measured shot with their hashes; one of poses alone has no frames."""
    shot, frames = manifest["shot"], manifest["frames"]
    kept = [] if frames is None else [(f"{shot}/{frames['file']}", str(frames["sha256"]))]
    read = (files.manifest, files.result)
    return [*kept, *((f"{shot}/{path.name}", _sha256(path)) for path in read)]


def _utc(time: datetime) -> datetime:
    """Return a time in UTC; one without a zone is taken as UTC (exchange-folder.md)."""
    return time.replace(tzinfo=UTC) if time.tzinfo is None else time.astimezone(UTC)


def _why_missing(shot: ShotRecord) -> str | None:
    """Return why nothing of this shot counts; None: it does."""
    if shot.excluded is not None:
        return _excluded(shot.excluded)
    if shot.state is ShotState.ANALYSED:
        return None
    return f"{shot.state.replace('_', ' ')}: {shot.failure or 'no measurement of it yet'}"


def _excluded(reason: str | None) -> str:
    return f"excluded by a person: {reason}" if reason else "excluded by a person"


def _when(shots: Sequence[ShotRecord], manifests: Sequence[Json]) -> tuple[tuple[str, str], ...]:
    programs = {f"{p['name']} {p['version']}" for m in manifests if (p := m.get("program"))}
    recorded = {m["recording"]["by"] for m in manifests if "recording" in m}
    return (
        ("first shot accepted (UTC)", shots[0].accepted_at.isoformat(timespec="seconds")),
        ("last shot accepted (UTC)", shots[-1].accepted_at.isoformat(timespec="seconds")),
        ("fired by program", ", ".join(sorted(programs)) or "not recorded"),
        ("recording confirmed by", ", ".join(sorted(recorded)) or "not recorded"),
        ("configuration (SHA-256)", ", ".join(sorted({shot.configuration for shot in shots}))),
    )


def _ranges(settings: Sequence[Mapping[str, float]]) -> tuple[tuple[str, str], ...]:
    """Return each numeric setting with the range and number of its values."""
    names = dict.fromkeys(name for own in settings for name in own)
    found = []
    for name in names:
        values = sorted({own[name] for own in settings if name in own})
        text = f"{values[0]:g}"
        if len(values) > 1:
            text += f" to {values[-1]:g}, {len(values)} values"
        found.append((name, text))
    return tuple(found)


def _numbers(settings: Mapping[str, Any]) -> dict[str, float]:
    return {name: float(value) for name, value in settings.items() if value is not None}


def _facts(document: Mapping[str, Any], heading: str) -> list[Facts]:
    """Return a document's sections as facts; single values stand together under a heading."""
    single = [(name, _text(v)) for name, v in document.items() if not _nested(v)]
    parts = [Facts(heading, tuple(single))] if single else []
    for name, value in document.items():
        if isinstance(value, Mapping):
            parts.append(Facts(name, tuple(_flat(value))))
        elif _nested(value):
            parts += [Facts(f"{name} {k + 1}", tuple(_flat(v))) for k, v in enumerate(value)]
    return parts


def _nested(value: object) -> bool:
    return isinstance(value, Mapping) or (
        isinstance(value, list) and bool(value) and all(isinstance(v, Mapping) for v in value)
    )


def _flat(section: Mapping[str, Any], before: str = "") -> Iterable[tuple[str, str]]:
    for name, value in section.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{before}{name}.")
        elif value is not None:
            yield f"{before}{name}", _text(value)


def _text(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.12g}"
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def _json(path: Path) -> Json:
    document: Json = json.loads(path.read_bytes())
    return document


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
