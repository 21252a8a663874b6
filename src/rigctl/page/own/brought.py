"""Files that were dropped on the page: kept in a folder of their own inside the store's."""

from __future__ import annotations

import json
import re
import secrets
import shutil
import zipfile
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import IO

from analysis.balls.films.reading import FILM_SUFFIXES, PHOTRON_SUFFIXES
from analysis.balls.films.stacks import PICTURE_SUFFIXES
from analysis.balls.tracks.table import is_table_of_bounces, is_track_table
from analysis.imaging.files.tiff_file import holds_pages
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError
from rigctl.page.model.source import LOOKED_AT

FOLDER = "own"
"""Folder of what was brought, inside the store's."""
NAME = re.compile(r"[A-Za-z0-9_. -]{1,120}")
TOKEN = re.compile(r"[0-9a-f]{16}")
PART = ".part"
"""Ends the name of a folder whose files are not all there and looked at."""
MOST_BYTES = 2 * 1024**3
MOST_FILES = 20_000
ARCHIVE = ".zip"
FRAMES = "frames"
TABLES = (".csv", ".tsv")
MOST_LISTED = 12
MEASURED = "measured"
"""Folder of what comes of it."""
FIGURE, RESULT, CAMPAIGN = "bounces", "result", "campaign"
"""Figures and results with the number of their film from 1, and the campaign of them all."""


class _Bounded:
    """The first bytes of a stream."""

    def __init__(self, stream: IO[bytes], most: int) -> None:
        self._stream, self._left = stream, most

    def read(self, size: int = -1) -> bytes:
        """Return the next bytes of those that are allowed."""
        wanted = self._left if size < 0 else min(size, self._left)
        part = self._stream.read(wanted) if wanted else b""
        self._left -= len(part)
        return part


@dataclass(frozen=True, slots=True)
class Brought:
    """One thing that was brought, in a folder of its own.

    Attributes
    ----------
    films
        Films, each a file or a folder of pictures; none for a table and a campaign.
    table
        A table as CSV.
    campaign
        The exchange folder.
    """

    folder: Path
    films: tuple[Path, ...] = ()
    table: Path | None = None
    campaign: Path | None = None

    @property
    def token(self) -> str:
        """Its name in addresses."""
        return self.folder.name

    @property
    def name(self) -> str:
        """What was dropped, in a few words."""
        if self.films:
            more = f" and {len(self.films) - 1} more" if len(self.films) > 1 else ""
            return f"{self.films[0].name}{more}"
        return (self.table or self.campaign or self.folder).name

    def results(self) -> dict[int, Json]:
        """Return what was measured of the films, or of the table, before, by their place."""
        kept = self.folder / MEASURED
        paths = ((k, kept / f"{RESULT}-{k + 1}.json") for k in range(len(self.films) or 1))
        return {k: json.loads(path.read_text("utf-8")) for k, path in paths if path.is_file()}


def brought_before(store: Path) -> list[Brought]:
    """Return what was brought last, the latest first.

    What is unreadable is left out, and what is still being brought: to look at an archive unpacks
    it.
    """
    places = [place for place in (store / FOLDER).glob("*/") if TOKEN.fullmatch(place.name)]
    places.sort(key=lambda place: place.stat().st_mtime, reverse=True)
    found = []
    for place in places[:MOST_LISTED]:
        with suppress(AnalysisInputError):
            found.append(known(store, place.name))
    return found


def new_place(store: Path) -> Path:
    """Return a new folder for what is being brought; nothing finds it before it is `settled`."""
    place = store / FOLDER / f"{secrets.token_hex(8)}{PART}"
    place.mkdir(parents=True)
    return place


def settled(place: Path) -> str:
    """Give a new folder, whose files are all there, its lasting name; return that."""
    return place.rename(place.with_suffix("")).name


def forget_unsettled(store: Path) -> None:
    """Remove what an earlier daemon was taking in when it ended."""
    for place in (store / FOLDER).glob(f"*{PART}/"):
        if TOKEN.fullmatch(place.stem):
            shutil.rmtree(place, ignore_errors=True)


def known(store: Path, token: str) -> Brought:
    """Return what was brought under a name.

    Raises
    ------
    AnalysisInputError
        Nothing was, or it is neither a film nor a campaign.
    """
    place = store / FOLDER / token
    if not TOKEN.fullmatch(token) or not place.is_dir():
        raise AnalysisInputError("was not brought", part=token, todo="drop the file again")
    return what_is_in(place)


def safe_name(name: str) -> str:
    """Return the last part of a name that a browser states; raise where it is no plain name."""
    plain = PurePosixPath(name.replace("\\", "/")).name
    if not NAME.fullmatch(plain) or plain.startswith("."):
        raise AnalysisInputError(
            "has a name that cannot be kept",
            part=plain[:40],
            todo="rename it with letters, digits, dots and hyphens",
        )
    return plain


def what_is_in(place: Path) -> Brought:
    """Return what a folder holds: an archive is unpacked, pictures beside each other are a film.

    Raises
    ------
    AnalysisInputError
        It is neither film nor campaign, or the archive is broken, too large or unsafe.
    """
    for archive in place.glob(f"*{ARCHIVE}"):
        # A campaign at the top of its archive is called what the archive is.
        _unpack(archive, place / "unpacked" / archive.stem)
        archive.unlink()
    described = [
        *place.glob(LOOKED_AT[0]),
        *sorted(place.glob(f"unpacked/**/{LOOKED_AT[0]}"), key=lambda path: len(path.parts)),
    ]
    if described:
        return Brought(place, campaign=described[0].parent)
    frames = place / FRAMES
    if frames.is_dir():
        # Pictures that were gathered before, from an archive or beside each other.
        return Brought(place, films=(frames,))
    unpacked = place / "unpacked"
    where = unpacked if unpacked.is_dir() else place
    made = place / MEASURED
    top = [path for path in sorted(where.rglob("*")) if path.is_file() and made not in path.parents]
    tables = [path for path in top if path.suffix.lower() in TABLES or looks_tracked(path)]
    films = [path for path in top if path.suffix.lower() in FILM_SUFFIXES]
    pictures = [path for path in top if path.suffix.lower() in PICTURE_SUFFIXES]
    if len(pictures) > 1 and not all(map(holds_pages, pictures)):
        frames.mkdir()
        for path in pictures:
            path.rename(frames / path.name)
        return Brought(place, films=(frames,))
    if films:
        recordings = {_recording(path): path for path in films}
        return Brought(place, films=tuple(recordings.values()))
    if tables:
        return Brought(place, table=tables[0])
    kinds = ", ".join(FILM_SUFFIXES)
    raise AnalysisInputError(
        "is neither film, table nor campaign",
        part=", ".join(path.name for path in top[:3]) or "nothing",
        todo=f"drop films ({kinds}), pictures of one film ({', '.join(PICTURE_SUFFIXES)}), a "
        "table as CSV, or an exchange folder as ZIP",
    )


def looks_tracked(path: Path) -> bool:
    """Return whether a file is a table of a tracker's places, or of bounces that were heard."""
    return is_track_table(path) or is_table_of_bounces(path)


def _recording(path: Path) -> str:
    """Return the name of the recording of a film: Photron's is of two files."""
    return path.stem if path.suffix.lower() in PHOTRON_SUFFIXES else path.name


def _unpack(archive: Path, into: Path) -> None:
    """Unpack an archive of plain files below a folder, within bounds."""
    try:
        with zipfile.ZipFile(archive) as packed:
            members = [one for one in packed.infolist() if not one.is_dir()]
            size = sum(one.file_size for one in members)
            if len(members) > MOST_FILES or size > MOST_BYTES:
                raise AnalysisInputError(
                    "is too large when unpacked",
                    part=archive.name,
                    value=f"{len(members)} files, {size / 1e6:.0f} MB",
                    limit=f"{MOST_FILES} files, {MOST_BYTES / 1e6:.0f} MB",
                )
            for one in members:
                target = (into / one.filename).resolve()
                if into.resolve() not in target.parents:
                    raise AnalysisInputError(
                        "holds a file that would lie outside of it", part=archive.name
                    )
                target.parent.mkdir(parents=True, exist_ok=True)
                with packed.open(one) as source, target.open("wb") as sink:
                    # Not more than it says: the sum of that was allowed.
                    shutil.copyfileobj(_Bounded(source, one.file_size), sink)
    except (zipfile.BadZipFile, OSError, NotImplementedError, RuntimeError) as error:
        shutil.rmtree(into, ignore_errors=True)
        raise AnalysisInputError(f"cannot be unpacked: {error}", part=archive.name) from error
