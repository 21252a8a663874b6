"""A campaign folder read a shot at a time gives the poses that it gives as a whole."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from analysis.errors import InputError
from analysis.model.data import parts, reading
from analysis.model.data.gather import gather_poses
from analysis.model.data.poses import PoseData
from analysis.model.data.reading import stream_poses
from tests.unit.analysis.model.data.parts import gathered
from tests.unit.analysis.model.exchange_folder import write_campaign
from tests.unit.analysis.model.hard_spheres import campaign

SHOTS = 9


@pytest.fixture(autouse=True)
def four_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reading, "SHOTS_AT_ONCE", 4)
    monkeypatch.setattr(parts, "SHOTS_AT_ONCE", 4)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_campaign(tmp_path / "campaign", campaign(SHOTS, 11))


def rewrite(folder: Path, change: Callable[[list[list[str]]], list[list[str]]]) -> None:
    path = folder / "poses.csv"
    head, *rows = path.read_text(encoding="utf-8").splitlines()
    changed = change([row.split(",") for row in rows])
    lines = [head, *(",".join(row) for row in changed)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def list_shots(folder: Path, *lines: str) -> None:
    (folder / "shots.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def assert_as_a_whole(folder: Path) -> PoseData:
    """Require the stream to be what the folder gives as a whole; return that."""
    name, stream = stream_poses(folder)
    wanted_name, wanted = gather_poses(folder)
    assert name == wanted_name
    assert stream.shots.tolist() == wanted.shots.tolist()
    assert (stream.unusable, stream.excluded) == (wanted.unusable, wanted.excluded)
    assert stream.estimated == wanted.estimated
    for field in ("times_s", "position", "position_sigma", "rotation", "rotation_sigma"):
        np.testing.assert_array_equal(gathered(stream, field), getattr(wanted, field), field)
    for part in stream.parts():
        assert part.camera == wanted.camera
        assert part.covariates.keys() == wanted.covariates.keys()
        assert part.slow == wanted.slow
    for covariate, values in wanted.covariates.items():
        found = np.concatenate([part.covariates[covariate] for part in stream.parts()])
        np.testing.assert_array_equal(found, values)
    return wanted


def test_all_poses_come_back_in_parts(folder: Path) -> None:
    assert_as_a_whole(folder)
    assert [len(part.shots) for part in stream_poses(folder)[1].parts()] == [4, 4, 1]


def test_reading_many_shots_takes_no_more_memory_than_reading_few(tmp_path: Path) -> None:
    few, many = (
        peak(write_campaign(tmp_path / str(shots), campaign(shots, 12))) for shots in (8, 40)
    )
    # The rows of 32 further shots have 2 MB as text, and as much as numbers.
    assert many < few + 2e5


def peak(folder: Path) -> int:
    """Return the most memory that reading allocates, bytes."""
    tracemalloc.start()
    try:
        stream_poses(folder)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_poses_csv_may_be_named_itself(folder: Path) -> None:
    assert stream_poses(folder / "poses.csv")[1].shots.tolist() == list(range(1, SHOTS + 1))


def test_order_of_firing_and_columns_are_those_of_the_whole_campaign(folder: Path) -> None:
    rows = [
        f"{n},2026-01-01T09:{(n * 7) % 60:02}:00Z,{20 + n},{n * n},{10 * n},{'' if n == 3 else n}"
        for n in range(SHOTS, 0, -1)
    ]
    list_shots(folder, "shot,time,pressure_a_kpa,moisture,exposure_us,only_some", *rows)
    wanted = assert_as_a_whole(folder)
    assert set(wanted.covariates) == {"order", "pressure_a_kpa", "moisture", "exposure_us"}
    assert wanted.camera.exposure_s == pytest.approx(90e-6)


def test_without_all_times_the_order_is_that_of_the_numbers(folder: Path) -> None:
    rows = [f"{n},{'' if n == 2 else f'2026-01-01T09:{50 - n}:00Z'}" for n in range(1, SHOTS + 1)]
    list_shots(folder, "shot,time", *rows)
    assert_as_a_whole(folder)


def test_shots_that_are_not_listed_leave_only_the_order(folder: Path) -> None:
    list_shots(folder, "shot,offset_mm", "1,3", "2,4", "77,5")
    assert set(assert_as_a_whole(folder).covariates) == {"order"}


def test_shots_that_a_person_excluded_are_left_out_and_named(folder: Path) -> None:
    words = {2: "chipped", 5: "dust", 6: "", 7: "late"}
    rows = [f"{n},{words.get(n, '')}" for n in range(1, SHOTS + 1)]
    list_shots(folder, "shot,excluded", *rows)
    assert assert_as_a_whole(folder).excluded == (2, 5, 7)


def test_shots_that_never_show_both_spheres_are_left_out_and_named(folder: Path) -> None:
    rewrite(folder, lambda rows: [r for r in rows if r[0] not in {"3", "8"} or r[3] == "a"])
    assert assert_as_a_whole(folder).unusable == (3, 8)


def test_a_shorter_shot_is_filled_up_with_what_was_not_measured(folder: Path) -> None:
    rewrite(folder, lambda rows: [r for r in rows if r[0] != "6" or int(r[1]) < 20])
    assert_as_a_whole(folder)


def test_errors_that_are_not_stated_are_guessed_alike_in_every_part(folder: Path) -> None:
    def left_out(rows: list[list[str]]) -> list[list[str]]:
        return [[*r[:7], "", *r[8:14], ""] if int(r[0]) > 4 else r for r in rows]

    rewrite(folder, left_out)
    wanted = assert_as_a_whole(folder)
    assert wanted.estimated
    assert np.isfinite(wanted.rotation_sigma).all()


def test_a_fault_in_the_middle_is_named_by_file_and_line(folder: Path) -> None:
    def spoilt(rows: list[list[str]]) -> list[list[str]]:
        rows[211][5] = "12,3".replace(",", ";")
        return rows

    rewrite(folder, spoilt)
    with pytest.raises(InputError, match="y_m: '12;3' is not a number") as fault:
        stream_poses(folder)
    assert (fault.value.path, fault.value.line) == (str(folder / "poses.csv"), 213)


def test_a_shot_that_goes_on_after_others_is_named_with_what_to_do(folder: Path) -> None:
    rewrite(folder, lambda rows: [*rows[:47], *rows[48:], rows[47]])
    with pytest.raises(InputError, match="shot 1 goes on after others; sort the rows") as fault:
        stream_poses(folder)
    assert fault.value.line == SHOTS * 48 + 1


def test_a_frame_that_stands_twice_is_named(folder: Path) -> None:
    rewrite(folder, lambda rows: [*rows[:5], rows[4], *rows[5:]])
    with pytest.raises(InputError, match="shot 1, frame 2, sphere a twice"):
        stream_poses(folder)


def test_shots_need_not_stand_in_the_order_of_their_numbers(folder: Path) -> None:
    rewrite(folder, lambda rows: sorted(rows, key=lambda r: -int(r[0])))
    assert_as_a_whole(folder)


def test_shots_out_of_order_may_have_frames_of_their_own_number(folder: Path) -> None:
    shorter = {"2": 20, "7": 17}
    rewrite(
        folder,
        lambda rows: sorted(
            (r for r in rows if int(r[1]) < shorter.get(r[0], 24)), key=lambda r: -int(r[0])
        ),
    )
    assert_as_a_whole(folder)


@pytest.mark.parametrize(
    ("file", "words"),
    [
        ("poses.csv", "rigctl analyse"),
        ("shots.csv", "no such file"),
        ("campaign.toml", "campaign.toml"),
    ],
)
def test_a_file_that_is_missing_is_named(folder: Path, file: str, words: str) -> None:
    (folder / file).unlink()
    with pytest.raises(InputError, match=words) as fault:
        stream_poses(folder)
    assert fault.value.path == str(folder / file)


def test_another_stage_is_not_read_a_shot_at_a_time(folder: Path) -> None:
    (folder / "contacts.csv").write_text("shot\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"only poses\.csv"):
        stream_poses(folder / "contacts.csv")
    assert stream_poses(folder)[1].shots.size == SHOTS


def test_a_table_without_poses_is_refused(folder: Path) -> None:
    rewrite(folder, lambda rows: [])
    with pytest.raises(InputError, match="no shot of this campaign"):
        stream_poses(folder)
