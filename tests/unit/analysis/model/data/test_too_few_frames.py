"""Shots that show too little of two spheres: named and left out, or refused in a sentence."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import pytest

from analysis.errors import InputError
from analysis.model.data.gather import gather_poses
from analysis.model.data.reading import stream_poses
from analysis.model.fitting.robust_fit import robust_fit
from simulators.challenge.campaign import run_campaign
from simulators.challenge.folder import write_folder
from simulators.challenge.nature import Nature

Row = dict[str, str]
MIDDLE = 12


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("few") / "whole"
    write_folder(folder, run_campaign(Nature(), 3, shots=3))
    return folder


def changed(whole: Path, folder: Path, change: Callable[[Row], Row | None]) -> Path:
    """Write the campaign with every row of its poses changed, or left out."""
    folder.mkdir()
    for name in ("campaign.toml", "shots.csv"):
        (folder / name).write_bytes((whole / name).read_bytes())
    with (whole / "poses.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    with (folder / "poses.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(row for own in rows if (row := change(dict(own))) is not None)
    return folder


def of_frames(first: int, last: int) -> Callable[[Row], Row | None]:
    return lambda row: row if first <= int(row["frame"]) < last else None


def in_one_place(row: Row) -> Row:
    return {**row, "x_m": "0.0", "y_m": "0.0", "z_m": "0.0"}


@pytest.mark.parametrize(
    "change",
    [of_frames(11, 13), of_frames(11, 14), of_frames(9, 13), in_one_place],
    ids=["two", "three", "three and one", "in one"],
)
def test_shots_that_show_no_flights_are_refused_with_what_is_needed(
    whole: Path, tmp_path: Path, change: Callable[[Row], Row | None]
) -> None:
    folder = changed(whole, tmp_path / "bad", change)
    for read in (gather_poses, stream_poses):
        with pytest.raises(InputError, match="2 frames or more that show both spheres apart"):
            read(folder)


def test_a_shot_of_three_frames_is_left_out_and_named_and_the_others_are_used(
    whole: Path, tmp_path: Path
) -> None:
    few = of_frames(11, 14)
    folder = changed(whole, tmp_path / "one", lambda row: few(row) if row["shot"] == "2" else row)
    data = gather_poses(folder)[1]
    assert data.shots.tolist() == [1, 3]
    assert data.unusable == (2,)


def test_of_a_shot_without_a_line_after_the_contact_is_named_and_the_others_are_used(
    whole: Path, tmp_path: Path
) -> None:
    early = of_frames(0, MIDDLE + 1)
    folder = changed(whole, tmp_path / "early", lambda r: early(r) if r["shot"] == "2" else r)
    for data in (gather_poses(folder)[1], stream_poses(folder)[1]):
        assert data.shots.tolist() == [1, 3]
        assert data.unusable == (2,)
        found = robust_fit(data)
        assert (len(found.fit.shot_chi2), found.rejected) == (2, [2])


def test_contacts_that_last_as_long_as_the_film_are_refused_in_a_sentence(
    whole: Path, tmp_path: Path
) -> None:
    folder = changed(whole, tmp_path / "soft", lambda row: row)
    with (folder / "campaign.toml").open("a", encoding="utf-8") as file:
        file.write("[material]\nyoungs_modulus_pa = 1e4\npoissons_ratio = 0.49\n")
    for read in (gather_poses, stream_poses):
        with pytest.raises(InputError, match="frames of the contact itself do not count"):
            read(folder)
