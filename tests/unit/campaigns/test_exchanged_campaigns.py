"""A campaign gives the same poses as a folder, imported, and exported after it was fired."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analysis.exchange.shot_list import read_shot_list
from analysis.model.data.gather import gather, gather_poses
from rigctl.errors import AnalysisInputError
from rigctl.exchange import export_campaign
from rigctl.exchange.contents import read_contents
from rigctl.exchange.importing import import_campaign
from rigctl.model.campaigns import campaign_poses, open_campaign
from rigctl.store import Store
from tests.unit.campaigns.test_campaign_poses import assert_same

Keep = Callable[..., list[str]]


def silent(_text: str, _share: float | None) -> None:
    """Say nothing."""


@pytest.fixture
def other(tmp_path: Path) -> Iterator[Store]:
    opened = Store(tmp_path / "other")
    yield opened
    opened.close()


def take(store: Store, folder: Path) -> str:
    contents = read_contents(folder, silent)
    return import_campaign(store, contents, "anna", name="nylon", progress=silent).campaign


def test_an_imported_campaign_gives_the_poses_of_its_folder(store: Store, folder: Path) -> None:
    wanted = gather(folder)[1]
    found = campaign_poses(store, take(store, folder))[1]
    assert_same(found, wanted)
    assert found.covariates.keys() == wanted.covariates.keys()
    for name in ("slow", "estimated"):
        assert getattr(found, name) == getattr(wanted, name), name


def test_excluded_shots_are_left_out_and_named_in_the_catalogue_and_in_its_folder(
    store: Store, folder: Path, tmp_path: Path
) -> None:
    take(store, folder)
    store.exclude("i0001-000002", "the tube was dirty", "anna")
    found = campaign_poses(store, "nylon")[1]
    assert (list(found.shots), found.excluded) == ([1, 3, 4], (2,))
    export_campaign(store, "nylon", tmp_path / "out", progress=silent)
    again = gather(tmp_path / "out")[1]
    assert_same(found, again)
    assert again.excluded == (2,)


def test_each_shot_is_exported_with_its_exposure_and_compared_with_the_longest(
    store: Store, keep: Keep, tmp_path: Path
) -> None:
    # The camera's exposure in a manifest, s; a shot of which none is known has no number.
    names = keep() + keep(exposure_s=1e-4) + keep(exposure_s=2.5e-4)
    for name in names:
        set_frames(store, name)
    export_campaign(store, "nylon", tmp_path / "out", progress=silent)
    rows = read_shot_list(tmp_path / "out" / "shots.csv")
    stated = [row.numbers.get("exposure_us") for row in rows]
    each = len(names) // 3
    assert stated == [None] * each + [100.0] * each + [250.0] * each
    assert campaign_poses(store, "nylon")[1].camera.exposure_s == pytest.approx(2.5e-4)
    assert gather_poses(tmp_path / "out")[1].camera.exposure_s == pytest.approx(2.5e-4)


def test_a_campaign_that_was_fired_is_exported_with_its_poses_frames_and_settings(
    store: Store, other: Store, keep: Keep, tmp_path: Path
) -> None:
    names = keep()
    for name in names:
        set_frames(store, name)
    store.exclude(names[1], "why", "anna")
    done = export_campaign(store, "nylon", tmp_path / "out", progress=silent)
    assert (done.shots, done.left_out) == (4, 0)
    fired, exported = campaign_poses(store, "nylon")[1], gather_poses(tmp_path / "out")[1]
    assert exported.excluded == fired.excluded == (2,)
    assert_nearly_same(exported, fired)
    take(other, tmp_path / "out")
    assert_nearly_same(campaign_poses(other, "nylon")[1], fired)
    pixels = other.frames("i0001-000001").pixels
    np.testing.assert_array_equal(pixels, store.frames(names[0]).pixels)
    export_campaign(other, "nylon", tmp_path / "again", progress=silent)
    for path in (path for path in (tmp_path / "out").rglob("*") if path.is_file()):
        same = tmp_path / "again" / path.relative_to(tmp_path / "out")
        assert same.read_bytes() == path.read_bytes(), path.name


def test_shots_of_two_setups_are_not_exported_as_one_folder(
    store: Store, keep: Keep, tmp_path: Path
) -> None:
    names = keep() + keep(picture_rate_hz=999.0)
    for name in names:
        set_frames(store, name)
    with pytest.raises(AnalysisInputError, match="differ in camera"):
        export_campaign(store, "nylon", tmp_path / "out", progress=silent)
    assert not (tmp_path / "out").exists()


def set_frames(store: Store, shot: str) -> None:
    """Say in the catalogue how many frames there are, as the rig does."""
    with store._database.writing() as connection:
        connection.exec_driver_sql("UPDATE shots SET frames = 1 WHERE id = ?", (shot,))


def assert_nearly_same(found: Any, wanted: Any) -> None:
    """Compare bit for bit what is written as it is; an orientation's length is rounded again."""
    for name in ("shots", "times_s", "position", "position_sigma", "rotation_sigma"):
        np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name), err_msg=name)
    np.testing.assert_allclose(found.rotation, wanted.rotation, rtol=0, atol=1e-14)
    assert found.covariates.keys() == wanted.covariates.keys()
    assert (found.camera, found.bodies) == (wanted.camera, wanted.bodies)


def test_a_campaign_of_tables_is_fitted_by_its_name_as_by_its_folder(
    store: Store, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tables = tmp_path / "tables"
    tables.mkdir()
    (tables / "campaign.toml").write_text((folder / "campaign.toml").read_text())
    (tables / "shots.csv").write_text("shot\n1\n2\n3\n")
    head = "shot,v_n,v_s,v_n_after,v_s_after,sigma_v_n,sigma_v_s,sigma_v_n_after,sigma_v_s_after"
    lines = (f"{k},-{3 + k},{k},2,0.5,0.01,0.01,0.01,0.01" for k in (1, 2, 3))
    (tables / "impacts.csv").write_text("\n".join([head, *lines]) + "\n")
    take(store, tables)
    store.exclude("i0001-000002", "why", "anna")
    store.close()
    monkeypatch.chdir(tmp_path)
    title, found = open_campaign(Path("nylon"))
    assert (title, list(found.shots), found.excluded) == ("nylon", [1, 3], (2,))
    wanted = gather(tables)[1]
    np.testing.assert_array_equal(found.numbers, wanted.numbers[[0, 2]])
    np.testing.assert_array_equal(found.sigma, wanted.sigma[[0, 2]])
    with pytest.raises(AnalysisInputError, match="campaign nylon: came with tabulated contacts"):
        open_campaign(Path("nylon"), poses=True)
    with pytest.raises(AnalysisInputError, match=r"neither poses\.csv nor frames is there"):
        open_campaign(tables, poses=True)
