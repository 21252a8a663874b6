"""What goes into the catalogue comes out of it, byte for byte."""

from __future__ import annotations

import json
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import cv2
import numpy as np
import pytest

from analysis.exchange.shot_list import read_shot_list
from rigctl.errors import NotFoundError, SettingsError, StoreError
from rigctl.exchange import export_campaign
from rigctl.exchange.importing import Imported
from rigctl.store import Fired, ShotState, Store, reading
from tests.unit.exchange.conftest import frames, silent

Take = Callable[..., Imported]


def files(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def test_an_imported_campaign_is_exported_byte_for_byte(
    store: Store, folder: Path, take: Take, tmp_path: Path
) -> None:
    take(folder)
    done = export_campaign(store, "nylon-2", tmp_path / "out", progress=silent)
    assert files(tmp_path / "out") == files(folder)
    assert (done.shots, done.left_out) == (3, 0)
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]


def test_a_store_that_is_only_read_exports_as_well(
    store: Store, folder: Path, take: Take, tmp_path: Path
) -> None:
    take(folder)
    with reading(store.path) as reader:
        export_campaign(reader, "nylon-2", tmp_path / "out", progress=silent)
    assert files(tmp_path / "out") == files(folder)


def test_every_shot_stands_where_its_folder_leaves_it(
    store: Store, folder: Path, take: Take
) -> None:
    assert take(folder) == Imported("nylon-2", shots=3, measured=1, to_analyse=1)
    with_poses, with_frames, bare = store.shots()
    assert [shot.id for shot in store.shots()] == [f"i0001-{n:06d}" for n in (3, 7, 12)]
    assert [shot.imported_as for shot in store.shots()] == [3, 7, 12]
    assert (with_poses.state, with_poses.results) == (ShotState.ANALYSED, 1)
    assert (with_frames.state, with_frames.frames) == (ShotState.STORED, 6)
    assert (bare.state, bare.frames, bare.settings) == (ShotState.REFUSED, None, None)
    assert bare.failure == "its folder holds nothing of this shot but its line"
    assert all(shot.fired is Fired.YES for shot in store.shots())
    assert with_poses.settings is not None
    assert with_poses.settings.pressure_b_kpa == 40.5
    assert with_poses.fired_at == datetime(2026, 1, 31, 12, tzinfo=UTC)
    assert with_frames.fired_at == datetime(2026, 1, 31, 11, 1, tzinfo=UTC)
    assert bare.fired_at is None


def test_frames_and_their_times_are_those_of_the_folder(
    store: Store, folder: Path, take: Take
) -> None:
    take(folder)
    from_tiff, from_array = (store.frames(f"i0001-{n:06d}") for n in (3, 7))
    np.testing.assert_array_equal(from_tiff.pixels, frames(3))
    np.testing.assert_array_equal(from_array.pixels, frames(7))
    np.testing.assert_array_equal(from_tiff.times_s, np.arange(6) / 1000)
    recorded = np.array([0.5, 0.501, 0.502, 0.504, 0.505, 0.506])
    np.testing.assert_array_equal(from_array.times_s, recorded - 0.5)
    with pytest.raises(NotFoundError, match="has no frames"):
        store.frames("i0001-000012")


def test_frames_of_a_photron_are_kept_with_their_header(
    store: Store, folder: Path, take: Take, tmp_path: Path
) -> None:
    (folder / "frames" / "0012.mraw").write_bytes(frames(12).tobytes())
    (folder / "frames" / "0012.cih").write_text(
        "Record Rate(fps) : 6000\nTotal Frame : 6\nImage Width : 24\nImage Height : 16\n"
        "Color Bit : 8\n"
    )
    take(folder)
    stored = store.frames("i0001-000012")
    np.testing.assert_array_equal(stored.pixels, frames(12))
    np.testing.assert_allclose(stored.times_s, np.arange(6) / 6000)
    export_campaign(store, "nylon-2", tmp_path / "out", progress=silent)
    assert files(tmp_path / "out") == files(folder)


def test_times_beside_a_folder_of_pictures_are_kept_with_it(
    store: Store, folder: Path, take: Take, tmp_path: Path
) -> None:
    (folder / "frames" / "0012").mkdir()
    for number, frame in enumerate(frames(12)):
        cv2.imwrite(str(folder / "frames" / "0012" / f"{number}.png"), frame)
    times = [0.0, 0.25, 0.5, 1.0, 1.25, 1.5]
    (folder / "frames" / "0012.json").write_text(json.dumps({"times_s": times}))
    take(folder)
    np.testing.assert_array_equal(store.frames("i0001-000012").times_s, times)
    export_campaign(store, "nylon-2", tmp_path / "out", progress=silent)
    assert files(tmp_path / "out") == files(folder)


def test_what_people_changed_comes_out_in_columns_of_its_own(
    store: Store, other: Store, folder: Path, take: Take, tmp_path: Path
) -> None:
    take(folder)
    store.exclude("i0001-000007", "the tube, it was dirty", "anna")
    store.tag("i0001-000003", ["wet", "cold"], "anna")
    store.annotate("i0001-000003", 'he said "good"', "anna")
    export_campaign(store, "nylon-2", tmp_path / "out", progress=silent)
    out, before = files(tmp_path / "out"), files(folder)
    assert {name for name in out if out[name] != before[name]} == {"shots.csv"}
    assert out.keys() == before.keys()
    assert out["shots.csv"].decode() == (
        "offset_mm,shot,time,pressure_a_kpa,pressure_b_kpa,operator,temperature_c,"
        "excluded,note,tags\r\n"
        '6.0,3,2026-01-31T12:00:00,40,40.50,anna,21,,"he said ""good""",cold;wet\r\n'
        '0,7,2026-01-31T12:01:00+01:00,20,20,ben,,"the tube, it was dirty",,\r\n'
        "1e1,12,,,,ben,22,,,\r\n"
    )
    take(tmp_path / "out", into=other)
    tagged, excluded, _ = other.shots()
    assert (tagged.tags, tagged.note) == (("cold", "wet"), 'he said "good"')
    assert excluded.excluded == "the tube, it was dirty"
    export_campaign(other, "nylon-2", tmp_path / "again", progress=silent)
    assert files(tmp_path / "again") == out


def test_an_exclusion_that_was_taken_back_leaves_the_folder_as_it_came(
    store: Store, folder: Path, take: Take, tmp_path: Path
) -> None:
    take(folder)
    store.exclude("i0001-000007", "why", "anna")
    store.include("i0001-000007", "anna")
    export_campaign(store, "nylon-2", tmp_path / "out", progress=silent)
    assert files(tmp_path / "out") == files(folder)


def test_a_campaign_keeps_its_own_name_in_its_folder_under_another_in_the_catalogue(
    store: Store, folder: Path, take: Take, tmp_path: Path
) -> None:
    take(folder)
    take(folder, name="theirs")
    export_campaign(store, "theirs", tmp_path / "out", progress=silent)
    assert files(tmp_path / "out") == files(folder)
    assert {shot.id for shot in store.shots(campaign="theirs")} >= {"i0002-000003"}
    assert store.edits.entries()[1].subject == "theirs"


def test_frames_that_were_damaged_in_the_store_are_not_exported(
    store: Store, folder: Path, take: Take, tmp_path: Path
) -> None:
    take(folder)
    kept = store.folders.folder("i0001-000003") / "frames" / "0003.tif"
    kept.write_bytes(kept.read_bytes()[:-1] + b"?")
    with pytest.raises(StoreError, match=r"0003\.tif.*not the file that was imported"):
        export_campaign(store, "nylon-2", tmp_path / "out", progress=silent)
    assert not (tmp_path / "out").exists()
    with pytest.raises(StoreError, match="not those that were recorded"):
        store.frames("i0001-000003")


def test_nothing_is_written_over(store: Store, folder: Path, take: Take, tmp_path: Path) -> None:
    take(folder)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine").write_text("keep")
    with pytest.raises(SettingsError, match="is there already"):
        export_campaign(store, "nylon-2", tmp_path / "out", progress=silent)
    assert files(tmp_path / "out") == {"mine": b"keep"}


def test_a_campaign_that_is_not_there_is_not_exported(store: Store, tmp_path: Path) -> None:
    with pytest.raises(NotFoundError, match="no such campaign"):
        export_campaign(store, "nylon-2", tmp_path / "out", progress=silent)
    assert not (tmp_path / "out").exists()


def test_a_shot_list_reads_exclusions_as_words_whatever_they_say(
    folder: Path,
) -> None:
    text = "shot,excluded,note,tags\n1,1,2,3\n2,,,\n"
    (folder / "shots.csv").write_text(text)
    first, second = read_shot_list(folder / "shots.csv")
    assert (first.numbers, first.words) == ({}, {"excluded": "1", "note": "2", "tags": "3"})
    assert first.is_excluded
    assert not second.is_excluded


REMARKS = b'# by anna\ntags = [ "wet", "cold" ]\nnote = "tubes cleaned each day"\n'


def test_note_and_tags_of_a_campaign_go_into_the_folder_and_come_back(
    store: Store, other: Store, folder: Path, take: Take, tmp_path: Path
) -> None:
    take(folder)
    store.annotate_campaign("nylon-2", 'he said "good" — 20 µm', "anna")
    store.tag_campaign("nylon-2", ["wet", "cold"], "anna")
    export_campaign(store, "nylon-2", tmp_path / "out", progress=silent)
    out = files(tmp_path / "out")
    assert out.pop("remarks.toml").decode() == (
        'note = "he said \\"good\\" — 20 µm"\ntags = ["cold", "wet"]\n'
    )
    assert out == files(folder)
    take(tmp_path / "out", into=other)
    record = other.campaigns.one("nylon-2")
    assert (record.note, record.tags) == ('he said "good" — 20 µm', ("cold", "wet"))
    export_campaign(other, "nylon-2", tmp_path / "again", progress=silent)
    assert files(tmp_path / "again") == files(tmp_path / "out")


def test_remarks_that_nobody_changed_come_out_as_they_were_written(
    store: Store, folder: Path, take: Take, tmp_path: Path
) -> None:
    (folder / "remarks.toml").write_bytes(REMARKS)
    take(folder)
    record = store.campaigns.one("nylon-2")
    assert (record.note, record.tags) == ("tubes cleaned each day", ("cold", "wet"))
    export_campaign(store, "nylon-2", tmp_path / "out", progress=silent)
    assert files(tmp_path / "out") == files(folder)
    store.annotate_campaign("nylon-2", None, "anna")
    export_campaign(store, "nylon-2", tmp_path / "changed", progress=silent)
    assert files(tmp_path / "changed")["remarks.toml"] == b'tags = ["cold", "wet"]\n'
    store.tag_campaign("nylon-2", [], "anna")
    export_campaign(store, "nylon-2", tmp_path / "bare", progress=silent)
    assert "remarks.toml" not in files(tmp_path / "bare")
