"""What an exchange folder holds, read to the last frame before anything of it is kept."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.balls.films.frames import read_frames
from analysis.balls.films.high_speed import FRAMES_SUFFIX, HEADER_SUFFIXES
from analysis.campaign import DESCRIPTION, FRAMES, POSES, SHOT_LIST, frames_of
from analysis.errors import InputError
from analysis.exchange.contact_table import read_contacts
from analysis.exchange.description import read_description
from analysis.exchange.impact_table import read_impacts
from analysis.exchange.pose_table import PoseRow, read_poses
from analysis.exchange.shot_list import EXCLUDED, NOTE, TAGS, ShotRow, read_shot_list
from analysis.imaging.files.stack import beside_frames
from analysis.model.data.gather import CONTACTS, IMPACTS
from analysis.setup import Setup
from rigctl.errors import AnalysisInputError
from rigctl.exchange.remarks import read_remarks
from rigctl.input_errors import as_analysis_errors
from rigctl.plain_text import require_plain
from rigctl.progress import Progress
from rigctl.store.campaign_remarks import Remarks

Poses = Mapping[str, Sequence[PoseRow]]

MOST_NAMED = 5
"""So many faults of frames are named at once; of more, only the number."""


@dataclass(frozen=True, slots=True)
class Frames:
    """The frames of one shot: where they lie, what was read of them, and their times in s.

    Attributes
    ----------
    dtype
        `uint8`, or `float32` where the file has more bits or colours: grey levels of 0 to 255.
    exposure_s
        Where a camera's own file says it, else None.
    notes
        A sentence on each thing about the file that could not be checked, or was made of it.
    """

    path: Path
    shape: tuple[int, int, int]
    dtype: str
    times_s: tuple[float, ...]
    exposure_s: float | None
    notes: tuple[str, ...]

    @property
    def files(self) -> list[Path]:
        """Every file of them, in order; files of their times and a camera's header among them."""
        beside = [beside_frames(self.path)]
        if self.path.suffix.lower() == FRAMES_SUFFIX:
            beside += [self.path.with_suffix(suffix) for suffix in HEADER_SUFFIXES]
        folder = self.path.is_dir()
        inside = sorted(self.path.rglob("*")) if folder else [self.path]
        return [path for path in (*inside, *beside) if path.is_file()]


@dataclass(frozen=True, slots=True)
class Contents:
    """An exchange folder in which everything could be read.

    Attributes
    ----------
    folder, title, setup, rows
        Where it is, the campaign's name, its set-up, and the lines of shots.csv.
    frames, poses
        By the number of the shot, where it has any.
    tabulated
        Numbers of the shots in contacts.csv or impacts.csv.
    remarks
        Note and tags of the campaign.
    """

    folder: Path
    title: str
    setup: Setup
    rows: tuple[ShotRow, ...]
    frames: Mapping[int, Frames]
    poses: Mapping[int, Poses]
    tabulated: frozenset[int]
    remarks: Remarks


def read_contents(folder: Path, progress: Progress) -> Contents:
    """Read a whole exchange folder.

    Raises
    ------
    AnalysisInputError
        A file is absent, of a later format, or cannot be read; frames that cannot are all named,
        with their shots. Something in the folder is no plain file, or no shot has any stage.
    SettingsError
        A name, note, tag or reason is no plain line.
    """
    with _nothing_imported():
        _require_plain(folder)
        title, setup = read_description(folder / DESCRIPTION)
        remarks = read_remarks(folder)
        rows = tuple(read_shot_list(folder / SHOT_LIST))
        if not rows:
            raise InputError(folder / SHOT_LIST, "names no shots")
        _require_plain_words(folder, title, rows)
        plate = any(sphere.plate for sphere in setup.spheres)
        poses = read_poses(folder / POSES) if (folder / POSES).exists() else {}
        tabulated: set[int] = set()
        if (folder / CONTACTS).exists():
            tabulated |= {row.shot for row in read_contacts(folder / CONTACTS, plate=plate)}
        if (folder / IMPACTS).exists():
            tabulated |= {row.shot for row in read_impacts(folder / IMPACTS)}
        _require_listed(folder, {row.shot for row in rows}, {*poses, *tabulated})
        frames = _frames(folder, setup, rows, progress)
        if not (frames or poses or tabulated):
            stages = f"{FRAMES}, {POSES}, {CONTACTS}, {IMPACTS}"
            raise InputError(folder, f"holds none of {stages}")
    return Contents(folder, title, setup, rows, frames, poses, frozenset(tabulated), remarks)


def _require_plain_words(folder: Path, title: str, rows: Sequence[ShotRow]) -> None:
    """Refuse names and remarks with characters that are not shown as they are stored."""
    require_plain(title, f"{folder / DESCRIPTION}: name")
    for row in rows:
        for column in (EXCLUDED, NOTE, TAGS):
            where = f"{folder / SHOT_LIST}: {column} of shot {row.shot}"
            require_plain(row.words.get(column), where)


def _frames(
    folder: Path,
    setup: Setup,
    rows: Sequence[ShotRow],
    progress: Progress,
) -> dict[int, Frames]:
    found, faults = {}, []
    for done, row in enumerate(rows):
        progress(f"reading shot {row.shot}", done / len(rows))
        path = frames_of(folder / FRAMES, row.shot)
        if not path.exists():
            continue
        try:
            stack = read_frames(path)
        except InputError as error:
            faults.append(f"shot {row.shot}: {error}")
            continue
        times = stack.times_s
        if times is None:
            times = np.arange(len(stack.pixels)) / setup.camera.frame_rate_hz
        found[row.shot] = Frames(
            path,
            stack.light.shape,
            str(stack.light.dtype),
            _listed(times),
            stack.exposure_s,
            stack.notes,
        )
    if faults:
        rest = len(faults) - MOST_NAMED
        more = f"; and {rest} more" if rest > 0 else ""
        raise InputError(folder, f"{'; '.join(faults[:MOST_NAMED])}{more}")
    return found


def _listed(times: NDArray[np.float64]) -> tuple[float, ...]:
    return tuple(map(float, times))


def _require_plain(folder: Path) -> None:
    """Refuse what a copy could not hold: a link may lead anywhere, and later somewhere else."""
    if not folder.is_dir():
        raise InputError(folder, "no such folder")
    for path in folder.rglob("*"):
        if path.is_symlink() or not (path.is_file() or path.is_dir()):
            raise InputError(path, "is neither a file nor a folder; only these are imported")


def _require_listed(folder: Path, listed: set[int], measured: set[int]) -> None:
    if unknown := sorted(measured - listed):
        raise InputError(folder / SHOT_LIST, f"has no line for the measured shots {unknown}")


@contextmanager
def _nothing_imported() -> Iterator[None]:
    """Add to each fault that nothing was imported."""
    try:
        with as_analysis_errors(todo="nothing was imported; correct the folder"):
            yield
    except OSError as error:
        raise AnalysisInputError(
            f"cannot be read: {error.strerror or error}",
            part=str(error.filename),
            todo="nothing was imported; correct the folder's rights",
        ) from error
