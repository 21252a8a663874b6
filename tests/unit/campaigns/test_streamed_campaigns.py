"""Stored shots taken up so many at a time give the poses that they give together."""

from __future__ import annotations

import errno
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import rigctl.model.campaigns as streamed
from analysis.model.data.poses import PoseData
from rigctl.errors import AnalysisInputError, NotFoundError, StoreError
from rigctl.measuring.measured import MeasuredFiles, measured_files
from rigctl.model.campaigns import campaign_poses, open_stream, stream_from
from rigctl.store import Store
from rigctl.temporary_room import temporary_room

Keep = Callable[..., list[str]]


@pytest.fixture(autouse=True)
def three_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streamed, "SHOTS_AT_ONCE", 3)


def joined(parts: list[PoseData], name: str) -> np.ndarray:
    return np.concatenate([getattr(part, name) for part in parts])


def test_stored_shots_give_the_poses_that_they_give_together(store: Store, keep: Keep) -> None:
    keep()
    _, wanted = campaign_poses(store, "nylon")
    parts = list(stream_from("nylon", measured_files(store, "nylon")).parts())
    for name in ("shots", "times_s", "position", "position_sigma", "rotation", "rotation_sigma"):
        np.testing.assert_array_equal(joined(parts, name), getattr(wanted, name))
    for name, values in wanted.covariates.items():
        np.testing.assert_allclose(np.concatenate([p.covariates[name] for p in parts]), values)
    assert {part.slow for part in parts} == {wanted.slow}
    assert {part.camera for part in parts} == {wanted.camera}


def test_shots_under_different_set_ups_are_refused_in_whichever_part_they_are(
    store: Store, keep: Keep
) -> None:
    keep()
    keep(picture_rate_hz=500.0)
    with pytest.raises(AnalysisInputError, match="differ in camera"):
        stream_from("nylon", measured_files(store, "nylon"))


def test_a_damaged_file_is_named(store: Store, keep: Keep) -> None:
    keep()
    files = measured_files(store, "nylon")
    files[3].result.write_text("{", encoding="utf-8")
    with pytest.raises(AnalysisInputError) as fault:
        stream_from("nylon", files)
    assert fault.value.part == str(files[3].result)


def test_a_campaign_without_shots_is_not_there() -> None:
    with pytest.raises(NotFoundError, match="no shot of this campaign"):
        stream_from("nylon", [])


def test_shots_that_all_were_excluded_leave_nothing_to_fit(store: Store, keep: Keep) -> None:
    keep()
    files = [MeasuredFiles(f.manifest, f.result, True) for f in measured_files(store, "nylon")]
    with pytest.raises(NotFoundError, match="no shot of this campaign"):
        stream_from("nylon", files)


def test_a_folder_is_read_as_it_is_and_its_faults_are_told_with_their_line(
    folder: Path, tmp_path: Path
) -> None:
    assert open_stream(folder)[1].shots.size == 4
    for name in ("campaign.toml", "shots.csv"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    lines = (folder / "poses.csv").read_text(encoding="utf-8").splitlines()
    lines[100] = lines[100].replace(",a,", ",c,").replace(",b,", ",c,")
    (tmp_path / "poses.csv").write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(AnalysisInputError, match="neither a nor b") as fault:
        open_stream(tmp_path)
    assert fault.value.part == f"{tmp_path / 'poses.csv'}, line 101"


def test_a_full_temporary_folder_is_named_with_what_to_do() -> None:
    with pytest.raises(StoreError, match="No space left") as fault, temporary_room():
        raise OSError(errno.ENOSPC, "No space left on device")
    assert "TMPDIR" in str(fault.value.todo)
