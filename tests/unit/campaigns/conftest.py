"""One small campaign, once as a folder and once as shots in a store."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analysis.exchange.pose_table import read_poses
from analysis.exchange.shot_list import read_shot_list
from rigctl.cameras.frames import FrameSequence
from rigctl.challenge import new
from rigctl.measuring.stored_poses import poses_document
from rigctl.settings import ShotSettings
from rigctl.store import Change, NewShot, ShotState, Store

NO_FRAMES = FrameSequence(
    np.zeros((1, 8, 8), dtype=np.uint8), np.zeros(1), np.zeros(1, dtype=np.int64), (), "none"
)
TO_STORED = (ShotState.FIRING, ShotState.CAPTURING, ShotState.STORED)


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a campaign folder of four shots that hides an effect."""
    place = tmp_path_factory.mktemp("campaign") / "nylon"
    new(place, seed=5, strength="full", shots=4)
    return place


def scene(folder: Path) -> dict[str, Any]:
    """Return what a manifest says of camera, spheres and surroundings."""
    about = tomllib.loads((folder / "campaign.toml").read_text())
    camera = about["camera"]
    optics = ("front_view_rows", "top_view_rows", "front_origin_px", "top_origin_px")
    return {
        "picture_rate_hz": camera["frame_rate_hz"],
        "camera": {"rows": camera["height_px"], "columns": camera["width_px"]},
        "optics": {key: camera[key] for key in (*optics, "scale_px_per_m")},
        "spheres": about["spheres"],
        "environment": about["environment"],
    }


@pytest.fixture
def keep(store: Store, folder: Path) -> Callable[..., list[str]]:
    """Put the shots of the folder into the store, measured; return their names."""

    def put(campaign: str = "nylon", **changes: Any) -> list[str]:
        poses = read_poses(folder / "poses.csv")
        names = []
        for row in read_shot_list(folder / "shots.csv"):
            keys = ("pressure_a_kpa", "pressure_b_kpa", "offset_mm")
            settings = ShotSettings(**{key: row.numbers[key] for key in keys})
            assert row.time is not None
            about = NewShot(settings, campaign, None, "tester", True, "c0ffee", row.time)
            key = f"{campaign} {row.shot} {changes}"
            record, _ = store.accept(key, "body", lambda about=about: about)
            for state in TO_STORED:
                store.move(record.id, state)
            manifest = {
                "shot": record.id,
                "number": record.number,
                "fired_at": datetime.isoformat(row.time),
                "settings": settings.model_dump(mode="json"),
                **scene(folder),
                **changes,
            }
            store.folders.write(record.id, NO_FRAMES, manifest)
            measure(store, record.id, {"poses": poses_document(poses[row.shot])})
            names.append(record.id)
        return names

    return put


def measure(store: Store, shot: str, result: dict[str, Any]) -> None:
    store.move(shot, ShotState.ANALYSING)
    number = store.folders.add_result(shot, json.loads(json.dumps(result)))
    store.move(shot, ShotState.ANALYSED, Change(results=number))
