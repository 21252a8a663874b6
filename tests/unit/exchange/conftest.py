"""An exchange folder made by hand, and two stores."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import tifffile

from rigctl.exchange.contents import read_contents
from rigctl.exchange.importing import Imported, import_campaign
from rigctl.store import Store

DESCRIPTION = """# made by hand
format = 1
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
"""
SHOTS = (
    "offset_mm,shot,time,pressure_a_kpa,pressure_b_kpa,operator,temperature_c\r\n"
    "6.0,3,2026-01-31T12:00:00,40,40.50,anna,21\r\n"
    "0,7,2026-01-31T12:01:00+01:00,20,20,ben,\r\n"
    "1e1,12,,,,ben,22\r\n"
)
POSES = (
    "shot,frame,t_s,sphere,x_m,y_m,z_m,sigma_x_m,sigma_y_m,sigma_z_m,qw,qx,qy,qz,sigma_rot_rad\n"
    "3,0,0.0,a,0.001,-0.02,0,2e-5,2e-5,,1,0,0,0,0.008\n"
    "3,0,0.0,b,0.001,0.02,,2e-5,,,,,,,\n"
    "3,1,0.001,a,0.0010000000000000002,-0.018,0,2e-5,2e-5,2e-5,0,1,0,0,\n"
)


def frames(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, (6, 16, 24), dtype=np.uint8)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Shot 3 has poses and a TIFF, 7 frames with times of their own, 12 nothing but its line."""
    made = tmp_path / "from another lab"
    (made / "frames").mkdir(parents=True)
    (made / "campaign.toml").write_text(DESCRIPTION)
    (made / "shots.csv").write_bytes(SHOTS.encode())
    (made / "poses.csv").write_text(POSES)
    (made / "README.md").write_text("what was done\n")
    tifffile.imwrite(made / "frames" / "0003.tif", frames(3))
    np.save(made / "frames" / "0007.npy", frames(7))
    times = [0.5, 0.501, 0.502, 0.504, 0.505, 0.506]
    (made / "frames" / "0007.json").write_text(json.dumps({"times_s": times}))
    np.save(made / "frames" / "0099.npy", frames(99))
    return made


@pytest.fixture
def other(tmp_path: Path) -> Iterator[Store]:
    opened = Store(tmp_path / "other")
    yield opened
    opened.close()


def silent(_text: str, _share: float | None) -> None:
    """Say nothing."""


@pytest.fixture
def take(store: Store) -> Callable[..., Imported]:
    def take_in(folder: Path, name: str | None = None, into: Store = store) -> Imported:
        contents = read_contents(folder, silent)
        return import_campaign(into, contents, "anna", name=name, progress=silent)

    return take_in
