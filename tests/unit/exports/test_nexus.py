"""A NeXus file says all that the campaign says, each number with its unit."""

from __future__ import annotations

import importlib.util
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analysis.model.data.poses import PoseData
from analysis.results.campaign import Results, results
from analysis.setup import SlowErrors
from rigctl.cli import run
from rigctl.cli.store.exchange_other import require
from rigctl.errors import ConfigurationError, StoreError
from rigctl.reports.source import Source

h5py: Any = pytest.importorskip("h5py")
from rigctl.exports.nexus import write_nexus  # noqa: E402 - needs the library above


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory, source: Source, found: Results) -> Path:
    path = tmp_path_factory.mktemp("nexus") / "nylon.nxs"
    write_nexus(path, source, found)
    return path


def test_a_round_trip_gives_the_same_poses_and_the_same_results(
    written: Path, source: Source, found: Results
) -> None:
    assert isinstance(source.data, PoseData)
    with h5py.File(written) as file:
        poses = file["entry/poses"]
        again = replace(
            source.data,
            shots=poses["shot"][()],
            times_s=poses["time"][()],
            position=poses["position"][()],
            position_sigma=poses["position_errors"][()],
            rotation=poses["orientation"][()],
            rotation_sigma=poses["orientation_errors"][()],
            gravity=float(poses["gravity"][()]),
            slow=SlowErrors(
                position_m=float(poses["slow_position_errors"][()]),
                rotation_rad=float(poses["slow_orientation_errors"][()]),
                scale=float(poses["scale_error"][()]),
                one_body_frame=bool(poses["one_body_frame"][()]),
            ),
        )
        stored = file["entry/coefficients/velocities"][()]
        e = file["entry/regression/e"][()]
    for name in ("position", "position_sigma", "rotation", "rotation_sigma", "times_s"):
        np.testing.assert_array_equal(getattr(again, name), getattr(source.data, name))
    once_more = results(again)
    np.testing.assert_array_equal(once_more.impacts.velocities, stored)
    assert once_more.lines.law.e == e == found.lines.law.e


def test_every_group_has_its_class_and_every_number_its_unit(written: Path) -> None:
    without: list[str] = []

    def look(name: str, item: Any) -> None:
        if isinstance(item, h5py.Group):
            if not str(item.attrs.get("NX_class", "")).startswith("NX"):
                without.append(name)
        elif item.dtype.kind in "iuf" and not item.attrs.get("units"):
            without.append(name)

    with h5py.File(written) as file:
        file.visititems(look)
        assert file.attrs["NX_class"] == "NXroot"
    assert without == []


def test_units_are_those_of_the_quantities(written: Path) -> None:
    wanted = {
        "poses/position": "m",
        "poses/orientation_errors": "rad",
        "coefficients/approach_speed_errors": "m/s",
        "coefficients/e": "1",
        "settings/pressure_a_kpa": "kPa",
        "settings/offset_mm": "mm",
        "sample/sphere_a/inertia": "kg m^2",
    }
    with h5py.File(written) as file:
        assert {name: file[f"entry/{name}"].attrs["units"] for name in wanted} == wanted


def test_the_default_plot_is_restitution_against_speed(written: Path) -> None:
    with h5py.File(written) as file:
        data = file[file.attrs["default"]][file["entry"].attrs["default"]]
        assert data.attrs["NX_class"] == "NXdata"
        signal, (axis,) = data[data.attrs["signal"]], data.attrs["axes"]
        assert signal.shape == data[axis].shape == data["e_errors"].shape


def test_every_shot_that_is_not_in_it_is_named(
    tmp_path: Path, source: Source, found: Results, folder: Path
) -> None:
    from analysis.results.impacts import LeftOut

    path = tmp_path / "nylon.nxs"
    write_nexus(path, replace(source, missing=(LeftOut(7, "a hair"),)), found)
    with h5py.File(path) as file:
        left_out = file["entry/left_out"]
        assert 7 in left_out["shot"][()]
        assert b"a hair" in left_out["reason"][()]
        names = [name.decode() for name in file["entry/files/name"][()]]
    assert names == ["campaign.toml", "shots.csv", "poses.csv"]
    assert folder.exists()


def test_a_file_that_is_there_is_kept(tmp_path: Path, source: Source, found: Results) -> None:
    path = tmp_path / "old.nxs"
    path.write_text("old")
    with pytest.raises(StoreError, match="is there already"):
        write_nexus(path, source, found)
    assert path.read_text() == "old"
    with pytest.raises(StoreError, match="cannot be written"):
        write_nexus(tmp_path / "no" / "such.nxs", source, found)
    assert [entry.name for entry in tmp_path.iterdir()] == ["old.nxs"]


def test_the_command_writes_it(folder: Path, tmp_path: Path) -> None:
    assert run(["export-nexus", str(folder), str(tmp_path / "nylon.h5")]) == 0
    assert h5py.is_hdf5(tmp_path / "nylon.h5")


def test_without_the_library_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rigctl.cli.store.exchange_other.find_spec", lambda _: None)
    with pytest.raises(ConfigurationError, match=r"install rigctl\[hdf5\]"):
        require("h5py", "hdf5")
    assert importlib.util.find_spec("h5py") is not None
