"""What is learned of a pair, kept in a file, so that other processes and days need not learn it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import IO, Any
from zipfile import ZipFile

import numpy as np

from analysis.arrays import Floats
from analysis.errors import InputError
from analysis.files import file_limits
from analysis.imaging.views import View
from analysis.photometric.learn.appearance import Appearance, Sphere
from analysis.photometric.render.camera import Camera, Optics

FORMAT = 6
SPHERES = ("a", "b")
OWN = tuple(f.name for f in fields(Appearance) if f.name not in {"camera", "spheres"})
"""Numbers that are the pair's own."""
TUPLES = {"middle", "camera_sigma"}


def write_knowledge(file: IO[bytes], known: Appearance) -> None:
    """Write an uncompressed NPZ: every number as it is, in double precision."""
    parts: dict[str, Any] = {
        "format": FORMAT,
        "views": [view.value for view in known.camera.views],
        **{name: getattr(known, name) for name in OWN},
        **{f"optics.{name}": value for name, value in known.camera.optics._asdict().items()},
    }
    for letter, sphere in zip(SPHERES, known.spheres, strict=True):
        parts |= {f"{letter}.{f.name}": getattr(sphere, f.name) for f in fields(Sphere)}
    np.savez(file, allow_pickle=False, **parts)


def read_knowledge(path: Path) -> Appearance:
    """Return what `write_knowledge` has written, equal to the last bit.

    Raises
    ------
    InputError
        The file cannot be read, or is of another format.
    """
    try:
        _require_small(path)
        with path.open("rb") as file, np.load(file, allow_pickle=False) as parts:
            if int(parts["format"]) != FORMAT:
                raise InputError(path, f"format {int(parts['format'])}, {FORMAT} can be read")
            own: dict[str, Any] = {name: _plain(name, parts[name]) for name in OWN}
            optics: dict[str, Any] = {n: _plain(n, parts[f"optics.{n}"]) for n in Optics._fields}
            camera = Camera(tuple(View(str(name)) for name in parts["views"]), Optics(**optics))
            a, b = (_sphere(parts, letter) for letter in SPHERES)
            return Appearance(camera=camera, spheres=(a, b), **own)
    except InputError:
        raise
    # A damaged archive makes the library raise whatever its parsers stumble over.
    except Exception as error:
        raise InputError(path, f"holds nothing that was learned of a pair: {error}") from error


def _require_small(path: Path) -> None:
    """Refuse an archive that unpacks to more than its bytes, or to more than a document may have.

    What is learned is written as it is; packed, a few bytes could become any number.
    """
    most = 1e6 * file_limits().document_mb
    with ZipFile(path) as archive:
        unpacked = sum(entry.file_size for entry in archive.infolist())
    if unpacked > min(most, path.stat().st_size):
        raise ValueError(f"its parts unpack to {unpacked} bytes")


def _sphere(parts: Mapping[str, Floats], letter: str) -> Sphere:
    names = [f.name for f in fields(Sphere)]
    own: dict[str, Any] = {name: _plain(name, parts[f"{letter}.{name}"]) for name in names}
    return Sphere(**own)


def _plain(name: str, value: Floats) -> Floats | float | int | tuple[float, ...]:
    if name in TUPLES:
        return tuple(map(float, value))
    if value.ndim:
        return value
    number: float | int = value.item()
    return number
