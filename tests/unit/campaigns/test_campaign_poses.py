"""The same shots, once from the exchange folder and once from the store."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analysis.model.data.gather import gather
from rigctl.config import default_path
from rigctl.errors import AnalysisInputError, NotFoundError
from rigctl.measuring.measured import measured_files
from rigctl.model.campaigns import campaign_poses, open_campaign
from rigctl.store import Change, ShotState, Store, reading

Keep = Callable[..., list[str]]
ARRAYS = ("shots", "times_s", "position", "position_sigma", "rotation", "rotation_sigma")
SETTINGS = ("pressure_a_kpa", "pressure_b_kpa", "offset_mm", "order")


def assert_same(found: Any, wanted: Any) -> None:
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name), err_msg=name)
    for name in ("bodies", "gravity", "air_density", "camera"):
        assert getattr(found, name) == getattr(wanted, name), name
    for name in SETTINGS:
        np.testing.assert_array_equal(found.covariates[name], wanted.covariates[name])


def test_stored_shots_give_the_poses_of_their_exchange_folder(
    store: Store, keep: Keep, folder: Path
) -> None:
    keep()
    title, found = campaign_poses(store, "nylon")
    assert title == "nylon"
    assert_same(found, gather(folder)[1])


def test_a_store_that_is_only_read_gives_the_same(store: Store, keep: Keep, folder: Path) -> None:
    keep()
    with reading(store.path) as reader:
        assert_same(campaign_poses(reader, "nylon")[1], gather(folder)[1])


def test_shots_of_other_campaigns_and_those_not_measured_are_left_out(
    store: Store, keep: Keep
) -> None:
    first, *others = keep()
    keep("brass")
    store.move(first, ShotState.ANALYSING)
    _, found = campaign_poses(store, "nylon")
    assert list(found.shots) == [2, 3, 4]
    assert len(others) == 3


def test_the_latest_result_of_a_shot_counts(store: Store, keep: Keep) -> None:
    first, *_ = keep()
    before = measured_files(store, "nylon")[0]
    store.move(first, ShotState.ANALYSING)
    store.folders.add_result(first, store.result(first))
    store.move(first, ShotState.ANALYSED, Change(results=2))
    after = measured_files(store, "nylon")[0]
    assert (before.result.name, after.result.name) == ("result-0001.json", "result-0002.json")


def test_results_without_poses_are_named_with_what_to_do(store: Store, keep: Keep) -> None:
    keep()
    result = measured_files(store, "nylon")[2].result
    result.write_text(json.dumps({"status": "measured"}))
    with pytest.raises(AnalysisInputError) as found:
        campaign_poses(store, "nylon")
    assert found.value.part == str(result)
    assert found.value.todo == "have campaign nylon analysed again"


def test_a_damaged_file_is_named(store: Store, keep: Keep) -> None:
    keep()
    manifest = measured_files(store, "nylon")[1].manifest
    manifest.write_text(manifest.read_text()[:-1])
    with pytest.raises(AnalysisInputError, match=r"manifest\.json: cannot be read"):
        campaign_poses(store, "nylon")


def test_shots_under_different_set_ups_are_not_thrown_together(store: Store, keep: Keep) -> None:
    (first, *_), (other, *_) = keep(), keep(picture_rate_hz=500.0)
    with pytest.raises(AnalysisInputError, match=f"shots {first} and {other} differ in camera"):
        campaign_poses(store, "nylon")


def configuration(tmp_path: Path, store: Path) -> Path:
    text = default_path().read_text(encoding="utf-8")
    lines = [f'folder = "{store}"' if s.startswith("folder = ") else s for s in text.splitlines()]
    path = tmp_path / "rig.toml"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def test_a_folder_is_used_as_it_is_and_a_name_is_looked_up_in_the_store(
    store: Store, keep: Keep, folder: Path, tmp_path: Path
) -> None:
    keep("brass")
    rig = configuration(tmp_path, store.path)
    assert open_campaign(folder, rig)[0] == gather(folder)[0]
    title, found = open_campaign(Path("brass"), rig)
    assert (title, len(found.shots)) == ("brass", 4)
    with pytest.raises(NotFoundError, match="no such campaign"):
        open_campaign(Path("steel"), rig)


def test_a_folder_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(AnalysisInputError, match=r"campaign\.toml: no such file"):
        open_campaign(tmp_path)
