"""Any film: which reader a file or a folder needs."""

from __future__ import annotations

from pathlib import Path

from analysis.balls.films.cine import CineFilm
from analysis.balls.films.film import Film
from analysis.balls.films.photron import FRAMES_SUFFIX, HEADER_SUFFIXES, PhotronFilm
from analysis.balls.films.stacks import (
    TIFF_SUFFIXES,
    PictureFolder,
    PictureStack,
    read_npy_frames,
)
from analysis.balls.films.video import VideoFilm
from analysis.errors import InputError
from analysis.imaging.files.png_files import SUFFIX as PNG_SUFFIX
from analysis.imaging.files.png_files import refuse_single
from analysis.imaging.files.tiff_file import read_tiff

VIDEO_SUFFIXES = (".avi", ".mkv", ".mp4", ".mov", ".m4v", ".webm")
CINE_SUFFIX = ".cine"
PHOTRON_SUFFIXES = (FRAMES_SUFFIX, *HEADER_SUFFIXES)
READ_SUFFIXES = (*TIFF_SUFFIXES, ".npy", PNG_SUFFIX, *VIDEO_SUFFIXES, CINE_SUFFIX)
"""Of files that hold all of a film: an empty one is none."""
FILM_SUFFIXES = (*TIFF_SUFFIXES, ".npy", *VIDEO_SUFFIXES, CINE_SUFFIX, *PHOTRON_SUFFIXES)


def open_film(path: Path) -> Film:
    """Open a film by what its name says that it is.

    Raises
    ------
    InputError
        Nothing is there, it is of another kind, or it cannot be read.
    """
    if not path.exists():
        raise InputError(path, "no such file or folder")
    suffix = path.suffix.lower()
    if path.is_file() and path.stat().st_size == 0 and suffix in READ_SUFFIXES:
        raise InputError(path, "is an empty file")
    try:
        if path.is_dir():
            return PictureFolder(path)
        if suffix in TIFF_SUFFIXES:
            return PictureStack(path, read_tiff)
        if suffix == ".npy":
            return PictureStack(path, read_npy_frames)
        if suffix in VIDEO_SUFFIXES:
            return VideoFilm(path)
        if suffix == CINE_SUFFIX:
            return CineFilm(path)
        if suffix in PHOTRON_SUFFIXES:
            return PhotronFilm(path)
        if suffix == PNG_SUFFIX:
            refuse_single(path)
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror or error}") from error
    kinds = ", ".join(FILM_SUFFIXES)
    raise InputError(path, f"films are read from {kinds}, or a folder of PNG or TIFF pictures")


def film_of_shot(folder: Path, shot: int) -> Path:
    """Return where the film of a shot lies in a campaign's `frames`; a folder where none does."""
    stem = folder / f"{shot:04d}"
    named = [stem.with_suffix(suffix) for suffix in FILM_SUFFIXES]
    return next((path for path in named if path.exists()), stem)
