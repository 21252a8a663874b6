"""Small valid files of every kind that rigctl reads, each with the reader that takes it."""

from __future__ import annotations

import base64
import io
import json
from collections.abc import Callable
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import tifffile

from analysis.campaign import THESIS_SETUP
from analysis.exchange.contact_table import CONTACTS, read_contacts
from analysis.exchange.description import read_description
from analysis.exchange.impact_table import read_impacts
from analysis.exchange.pose_table import each_shot, read_poses
from analysis.exchange.shot_list import read_shot_list
from analysis.imaging.files.stack import read_stack
from analysis.photometric.learn.appearance import (
    Appearance,
    Sphere,
    read_knowledge,
    write_knowledge,
)
from analysis.photometric.render.camera import camera_of
from rigctl import challenge
from rigctl.cameras import capture_folder
from rigctl.cli.frames import discs
from rigctl.config.loading import default_path, load
from rigctl.exchange.contents import read_contents
from rigctl.service import keyfile
from rigctl.sweeps.form import read_sweep

Read = Callable[[Path], object]

FRAMES = np.random.default_rng(5).integers(0, 256, (6, 16, 24), dtype=np.uint8)
DESCRIPTION = """format = 1
name = "nylon-2"
[camera]
frame_rate_hz = 1000.0
width_px = 24
height_px = 16
front_view_rows = [0, 16]
[[spheres]]
name = "a"
diameter_m = 0.0254
[[spheres]]
name = "b"
diameter_m = 0.0254
inertia_factor = 0.41
[environment]
drag_coefficient = 0.42
"""
SHOTS = (
    "offset_mm,shot,time,pressure_a_kpa,operator,temperature_c,tags\r\n"
    '6.0,3,2026-01-31T12:00:00,40,"an ""a"", na",21,wet;cold\r\n'
    "0,7,2026-01-31T12:01:00+01:00,20,ben,,\r\n1e1,12,,,ben,22,\r\n"
)
POSES = (
    "shot,frame,t_s,sphere,x_m,y_m,z_m,sigma_x_m,sigma_y_m,sigma_z_m,qw,qx,qy,qz,sigma_rot_rad\n"
    "3,0,0.0,a,0.001,-0.02,0,2e-5,2e-5,,1,0,0,0,0.008\n"
    "3,0,0.0,b,0.001,0.02,,2e-5,,,,,,,\n"
    "7,1,0.001,a,0.0010000000000000002,-0.018,0,2e-5,2e-5,2e-5,0,1,0,0,\n"
)
IMPACTS = "shot,v_n,v_s,v_n_after,v_s_after\n3,-1.2,0.4,1.1,0.3\n7,-1.4,,1.3,\n"
SWEEP = """campaign = "nylon-2"
repeat = 2
[grid]
pressure_a_kpa = { first = 20, last = 80, count = 7, spacing = "root" }
offset_mm = [0, 6, 12, 18]
[[shots]]
pressure_a_kpa = 95
pressure_b_kpa = 95
offset_mm = 2.8
"""


@dataclass(frozen=True, slots=True)
class Sample:
    """A valid file: its name, perhaps within folders, content, and what stands beside it unbroken.

    `read` is given the folder in which `name` lies.
    """

    kind: str
    name: str
    content: bytes
    read: Read
    beside: tuple[tuple[str, bytes], ...] = ()


def samples(room: Path) -> list[Sample]:
    """Return the samples; `room` is an empty folder in which some are made."""
    return [*_frames(room), *_tables(), *_settings(), *_documents(room), *_folders(room)]


def _named(name: str, read: Read) -> Read:
    return lambda folder: read(folder / name)


def _tiff(room: Path, **form: Any) -> bytes:  # noqa: ANN401
    path = room / "frames.tiff"
    tifffile.imwrite(path, FRAMES, photometric="minisblack", **form)
    return path.read_bytes()


def _video(room: Path, suffix: str, codec: str) -> bytes:
    path = room / f"frames{suffix}"
    # Larger than other samples: codecs have a least size.
    video = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*codec), 30.0, (64, 48), False)
    for frame in FRAMES:
        video.write(cv2.resize(frame, (64, 48)))
    video.release()
    return path.read_bytes()


def _png(frame: np.ndarray) -> bytes:
    return bytes(cv2.imencode(".png", frame)[1])


def _npy(values: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.save(file, values)
    return file.getvalue()


def _frames(room: Path) -> list[Sample]:
    stacks = {
        "plain": _tiff(room, metadata=None),
        "packed": _tiff(room, compression="zlib"),
        "ImageJ": _tiff(room, imagej=True),
        "OME": _tiff(room, ome=True),
        "big": _tiff(room, bigtiff=True),
        "tiles": _tiff(room, tile=(16, 16), metadata=None),
        "strips": _tiff(room, rowsperstrip=3, compression="zlib", predictor=True),
    }
    found = [
        Sample(f"TIFF, {name}", "f.tiff", content, _named("f.tiff", read_stack))
        for name, content in stacks.items()
    ]
    videos = {".avi": "FFV1", ".mkv": "FFV1", ".mp4": "mp4v"}
    found += [
        Sample(suffix[1:].upper(), f"f{suffix}", content, _named(f"f{suffix}", read_stack))
        for suffix, codec in videos.items()
        if (content := _video(room, suffix, codec))
    ]
    second = ("p/1.png", _png(FRAMES[1]))
    found.append(Sample("PNG", "p/0.png", _png(FRAMES[0]), _named("p", read_stack), (second,)))
    found.append(
        Sample("PNG, one picture", "d.png", _png(FRAMES[0]), _named("d.png", discs.read_image))
    )
    found.append(Sample("NPY", "f.npy", _npy(FRAMES), _named("f.npy", read_stack)))
    return found


def _tables() -> list[Sample]:
    fields = ["0.1" if name.startswith(("v", "w", "sigma")) else "0" for name in CONTACTS]
    state = dict(zip(CONTACTS, fields, strict=True)) | {"shot": "3", "ny": "1", "va_y": "1"}
    contacts = f"{','.join(CONTACTS)}\n{','.join(state.values())}\n"

    def contact_rows(path: Path) -> object:
        return read_contacts(path, plate=False)

    tables: dict[str, tuple[str, list[Read]]] = {
        "shots.csv": (SHOTS, [read_shot_list]),
        "poses.csv": (POSES, [read_poses, lambda path: list(each_shot(path))]),
        "contacts.csv": (contacts, [contact_rows]),
        "impacts.csv": (IMPACTS, [read_impacts]),
    }
    return [
        Sample(name, name, text.encode(), _named(name, read))
        for name, (text, readers) in tables.items()
        for read in readers
    ]


def _settings() -> list[Sample]:
    texts: dict[str, tuple[bytes, Read]] = {
        "campaign.toml": (DESCRIPTION.encode(), read_description),
        "rig.toml": (default_path().read_bytes(), load),
        "sweep.toml": (SWEEP.encode(), read_sweep),
    }
    return [Sample(name, name, text, _named(name, read)) for name, (text, read) in texts.items()]


def _documents(room: Path) -> list[Sample]:
    times = {"sequence": [*range(6)], "times_s": [0.5 + n / 1e3 for n in range(6)], "lost": [814]}
    note = {"frames": 6, "rows": 16, "columns": 24, "frame_rate_hz": 1000.0, **times}
    stack = ("s.tiff", _tiff(room, metadata=None))

    def noted(path: Path) -> object:
        return capture_folder.read_stack(path, picture_rate_hz=1000.0)

    return [
        _json("times beside frames", "f.json", times, _named("f.npy", read_stack), _npy_beside()),
        _json("capture folder", "s.json", note, _named("s.json", noted), (stack,)),
        Sample("capture folder, TIFF", *stack, _named("s.json", noted), (("s.json", _text(note)),)),
        *_challenge(),
        _json("key file", keyfile.FILE_NAME, {"url": "http://a:1", "key": "k"}, keyfile.read),
        Sample("lesson (NPZ)", "l.npz", _lesson(), _named("l.npz", read_knowledge)),
    ]


def _challenge() -> list[Sample]:
    label = {"answer": ["slip"], "effects": [], "like": {}, "beside": []}
    sealed = bytes(challenge.SALT_BYTES) + _text(label)
    public = {"format": 1, "sha256": sha256(sealed).hexdigest(), "names": ["slip", "drag"]}
    whole = (
        (challenge.PUBLIC, _text(public)),
        (challenge.SEALED, base64.b64encode(sealed)),
        (challenge.ANSWER, b'{"answer": ["slip"]}'),
    )
    return [
        Sample("challenge", name, content, challenge.reveal, _without(whole, name))
        for name, content in whole
    ]


def _without(files: tuple[tuple[str, bytes], ...], name: str) -> tuple[tuple[str, bytes], ...]:
    return tuple(file for file in files if file[0] != name)


def _json(
    kind: str,
    name: str,
    document: object,
    read: Read,
    beside: tuple[tuple[str, bytes], ...] = (),
) -> Sample:
    return Sample(kind, name, _text(document), read, beside)


def _text(document: object) -> bytes:
    return json.dumps(document).encode()


def _npy_beside() -> tuple[tuple[str, bytes], ...]:
    return (("f.npy", _npy(FRAMES)),)


def _lesson() -> bytes:
    numbers = np.random.default_rng(6)
    sphere = Sphere(
        radius_m=0.0127,
        markers=numbers.normal(size=(4, 3)),
        alpha=0.2,
        darkness=0.5,
        shading=numbers.normal(size=(2, 4)),
        reliefs=numbers.normal(size=(2, 3, 3)),
    )
    known = Appearance(
        camera=camera_of(THESIS_SETUP.camera, np.array([1500.0, 1500.0])),
        sigma_px=np.ones(2),
        spheres=(sphere, sphere),
        scale_sigma=0.01,
        limb_px=0.5,
        films=6,
        pattern_sigma_rad=2e-4,
        slow_px=0.002,
        shared_px=0.002,
        smear_px2=np.zeros(2),
        camera_sigma=(0.1, 0.1),
    )
    file = io.BytesIO()
    write_knowledge(file, known)
    return file.getvalue()


def _folders(room: Path) -> list[Sample]:
    whole = (
        ("c/campaign.toml", DESCRIPTION.encode()),
        ("c/shots.csv", SHOTS.encode()),
        ("c/poses.csv", POSES.encode()),
        ("c/remarks.toml", b'note = "a slow start"\ntags = ["wet", "cold"]\n'),
        ("c/frames/0003.tif", _tiff(room)),
        ("c/frames/0007.npy", _npy(FRAMES)),
    )

    def contents(folder: Path) -> object:
        return read_contents(folder / "c", lambda _text, _share: None)

    return [
        Sample("exchange folder", name, content, contents, _without(whole, name))
        for name, content in whole
    ]
