"""What is dropped on the page: films, pictures and campaigns are told apart, and bounded."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest
import tifffile

from analysis.balls.films.stacks import PICTURE_SUFFIXES
from rigctl.errors import AnalysisInputError
from rigctl.page.own.brought import (
    brought_before,
    forget_unsettled,
    known,
    new_place,
    safe_name,
    settled,
    what_is_in,
)


@pytest.fixture
def place(tmp_path: Path) -> Path:
    return new_place(tmp_path)


def pack(place: Path, **files: str) -> None:
    with zipfile.ZipFile(place / "brought.zip", "w") as archive:
        for name, text in files.items():
            archive.writestr(name, text)


def test_a_film_is_a_film(place: Path) -> None:
    (place / "drop.mp4").write_bytes(b"")
    assert what_is_in(place).films == (place / "drop.mp4",)


@pytest.mark.parametrize("suffix", PICTURE_SUFFIXES)
def test_pictures_beside_each_other_are_one_film(suffix: str, place: Path) -> None:
    """Of every kind that a folder of frames is read from."""
    names = [f"{number}{suffix}" for number in (1, 2, 3)]
    for name in names:
        (place / name).write_bytes(b"")
    found = what_is_in(place)
    [film] = found.films
    assert sorted(path.name for path in film.iterdir()) == names
    assert what_is_in(place) == found


def test_several_films_stay_several_and_two_files_of_one_recording_are_one(place: Path) -> None:
    for name in ("one.mp4", "two.mp4", "three.mraw", "three.cihx"):
        (place / name).write_bytes(b"")
    assert {path.stem for path in what_is_in(place).films} == {"one", "two", "three"}
    assert len(what_is_in(place).films) == 3


def test_a_table_is_a_table_and_the_files_of_a_campaign_are_one(place: Path) -> None:
    (place / "impacts.csv").write_text("")
    assert what_is_in(place).table == place / "impacts.csv"
    (place / "campaign.toml").write_text("")
    assert what_is_in(place).campaign == place


def test_what_was_measured_is_not_taken_for_what_was_brought(place: Path) -> None:
    (place / "drop.mp4").write_bytes(b"")
    (place / "measured" / "campaign").mkdir(parents=True)
    (place / "measured" / "campaign" / "impacts.csv").write_text("")
    assert what_is_in(place).films == (place / "drop.mp4",)


def test_an_archive_with_a_description_is_a_campaign_however_deep_it_lies(place: Path) -> None:
    pack(place, **{"steel/campaign.toml": "", "steel/frames/0001.tif": ""})
    assert what_is_in(place).campaign == place / "unpacked" / "brought" / "steel"
    token = settled(place)
    kept = place.with_name(token)
    assert known(kept.parents[1], token).campaign == kept / "unpacked" / "brought" / "steel"


def test_what_is_still_being_brought_is_neither_listed_nor_unpacked(place: Path) -> None:
    pack(place, **{"film/1.png": "", "film/2.png": ""})
    store = place.parents[1]
    assert brought_before(store) == []
    assert sorted(path.name for path in place.iterdir()) == ["brought.zip"]
    with pytest.raises(AnalysisInputError):
        known(store, place.name)
    what_is_in(place)
    token = settled(place)
    assert [one.token for one in brought_before(store)] == [token]


def test_what_was_never_brought_to_its_end_is_removed_and_nothing_else(place: Path) -> None:
    store = place.parents[1]
    whole = new_place(store)
    (whole / "drop.mp4").write_bytes(b"")
    (place.parent / "somebody's.part").mkdir()
    kept = {settled(whole), "somebody's.part"}
    forget_unsettled(store)
    assert {path.name for path in place.parent.iterdir()} == kept
    forget_unsettled(store / "of a rig where nothing was brought")


def test_tiffs_of_several_pages_are_films_and_those_of_one_are_pictures_of_one(place: Path) -> None:
    for name in ("low.tif", "high.tif"):
        tifffile.imwrite(place / name, np.zeros((3, 8, 8), np.uint8), photometric="minisblack")
    assert what_is_in(place).films == (place / "high.tif", place / "low.tif")
    for name in ("low.tif", "high.tif"):
        tifffile.imwrite(place / name, np.zeros((8, 8), np.uint8))
    assert what_is_in(place).films == (place / "frames",)


def test_an_archive_of_pictures_is_one_film_every_time_it_is_looked_at(place: Path) -> None:
    pack(place, **{"film/1.png": "", "film/2.png": "", "film/read me.txt": ""})
    found = what_is_in(place)
    [film] = found.films
    assert sorted(path.name for path in film.iterdir()) == ["1.png", "2.png"]
    assert what_is_in(place) == found


def test_a_campaign_at_the_top_of_its_archive_is_called_what_the_archive_is(place: Path) -> None:
    with zipfile.ZipFile(place / "nylon-2026.zip", "w") as archive:
        archive.writestr("campaign.toml", "")
    assert what_is_in(place).name == "nylon-2026"
    # Looked at again, when the archive is gone.
    assert what_is_in(place).name == "nylon-2026"


def test_no_file_of_an_archive_lies_outside_of_its_folder(place: Path) -> None:
    pack(place, **{"../../escaped.txt": "out"})
    with pytest.raises(AnalysisInputError, match="outside"):
        what_is_in(place)
    assert not (place.parent / "escaped.txt").exists()


def test_a_broken_archive_is_said_to_be_one(place: Path) -> None:
    (place / "torn.zip").write_bytes(b"PK\x03\x04 and nothing more")
    with pytest.raises(AnalysisInputError, match="cannot be unpacked"):
        what_is_in(place)


def test_what_is_neither_is_named_with_what_would_be(place: Path) -> None:
    (place / "letter.docx").write_bytes(b"")
    with pytest.raises(AnalysisInputError, match=r"letter.docx: is neither.*\.mp4"):
        what_is_in(place)


@pytest.mark.parametrize("name", ["../up.mp4", "C:\\films\\up.mp4", "up.mp4"])
def test_of_a_name_its_last_part_counts(name: str) -> None:
    assert safe_name(name) == "up.mp4"


@pytest.mark.parametrize("name", ["", ".hidden", "a\nb.mp4", "x" * 121])
def test_a_name_that_is_no_plain_one_is_refused(name: str) -> None:
    with pytest.raises(AnalysisInputError):
        safe_name(name)


@pytest.mark.parametrize("token", ["..", "0123456789abcdef", "", "../../etc"])
def test_nothing_is_found_under_a_name_that_was_not_given(tmp_path: Path, token: str) -> None:
    with pytest.raises(AnalysisInputError):
        known(tmp_path, token)
