import csv
import gc
import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
import tifffile
from rendered import setup_of
from scipy.spatial.transform import Rotation

from analysis.campaign import (
    AHEAD,
    THESIS_SETUP,
    Campaign,
    ShotJob,
    analyse_campaign,
    analyse_job,
    read_campaign,
)
from analysis.errors import InputError
from analysis.exchange.description import read_description
from analysis.exchange.folder import folder_writer
from analysis.exchange.shot_list import read_shot_list
from analysis.shot import AnalysisOptions, MeasuredShot, RefusedShot
from analysis.slow_errors import typical
from simulators.world import WorldDescription, write_campaign

CORRUPT = 2
Result = tuple[ShotJob, MeasuredShot | RefusedShot]
THESIS = AnalysisOptions(method="thesis")
"""Its errors are wide enough for times that are wrong by a factor of two."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three rendered shots, the second with a truncated file."""
    home = tmp_path_factory.mktemp("data") / "nylon"
    write_campaign(home, [40.0, 50.0, 60.0], [6.0, 8.0, 10.0], 3, frames=16)
    broken = home / "frames" / f"{CORRUPT:04d}.tiff"
    broken.write_bytes(broken.read_bytes()[:90_000])
    return home


@pytest.fixture(scope="module")
def results(folder: Path) -> list[Result]:
    done = analyse_campaign(read_campaign(folder), AnalysisOptions(), workers=1)
    return [(job, shot) for job, shot, _ in done]


@pytest.fixture(scope="module")
def written(results: list[Result], tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("out") / "exchange"
    with folder_writer(out, "nylon", [job for job, _ in results]) as write:
        for job, shot in results:
            if isinstance(shot, MeasuredShot):
                write(job.shot, shot)
    return out


def table(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_one_corrupt_shot_does_not_stop_the_others(results: list[Result]) -> None:
    assert [job.shot for job, _ in results] == [1, 2, 3]
    refused = results[1][1]
    assert isinstance(refused, RefusedShot)
    assert refused.step == "frames"
    assert "0002.tiff" in refused.reason
    assert all(isinstance(shot, MeasuredShot) for i, (_, shot) in enumerate(results) if i != 1)


def test_several_processes_give_the_same_results_in_the_same_order(
    folder: Path, results: list[Result]
) -> None:
    counts: list[tuple[int, int]] = []
    done = list(
        analyse_campaign(
            read_campaign(folder),
            AnalysisOptions(),
            workers=2,
            progress=lambda count, total: counts.append((count, total)),
        )
    )
    assert [job.shot for job, _, _ in done] == [1, 2, 3]
    assert [frames for _, _, frames in done] == [16, 0, 16]
    assert counts == [(1, 3), (2, 3), (3, 3)]
    for (_, here), (_, there, _) in zip(results, done, strict=True):
        if isinstance(here, MeasuredShot):
            assert isinstance(there, MeasuredShot)
            # Processes agree to rounding.
            assert there.impact.v_n.value == pytest.approx(here.impact.v_n.value, rel=1e-6)
            assert there.impact.v_n.sigma == pytest.approx(here.impact.v_n.sigma, rel=1e-6)


class Drawn(tuple[ShotJob, ...]):
    """Jobs that count how many of them were asked for."""

    count = 0

    def __iter__(self) -> Iterator[ShotJob]:
        for job in super().__iter__():
            Drawn.count += 1
            yield job


def test_no_more_shots_are_under_way_than_the_processes_need(tmp_path: Path) -> None:
    jobs = Drawn(ShotJob(k, tmp_path / f"{k}.tiff", THESIS_SETUP) for k in range(1, 41))
    done = analyse_campaign(Campaign("empty", jobs), THESIS, workers=2)
    for k, (job, result, _) in enumerate(done):
        assert job.shot == k + 1
        assert isinstance(result, RefusedShot)
        assert Drawn.count <= k + 2 * AHEAD
    assert k == 39


def test_a_campaign_takes_set_up_and_settings_from_its_files(folder: Path) -> None:
    campaign = read_campaign(folder)
    assert campaign.name == "nylon"
    job = campaign.jobs[1]
    assert job.row is not None
    assert job.row.numbers["offset_mm"] == 8.0
    assert job.frames == folder / "frames" / "0002.tiff"
    expected = setup_of(WorldDescription())
    assert job.setup.camera.scale_px_per_m == expected.camera.scale_px_per_m
    assert job.setup.spheres == expected.spheres


def test_jobs_are_made_from_the_list_each_time_and_none_is_held(tmp_path: Path) -> None:
    home = tmp_path / "long"
    home.mkdir()
    (home / "campaign.toml").write_text(
        'format = 1\nname = "long"\n'
        "camera = { frame_rate_hz = 250, width_px = 240, height_px = 192 }\n"
        'spheres = [{ name = "a", diameter_m = 0.0254 }, { name = "b", diameter_m = 0.0254 }]\n'
    )
    numbers = [*range(1, 301)]
    (home / "shots.csv").write_text("shot,offset_mm\n" + "".join(f"{k},{k}\n" for k in numbers))
    jobs = read_campaign(home).jobs
    assert (len(jobs), jobs[-1].shot, [job.shot for job in jobs[:2]]) == (300, 300, [1, 2])
    others = held_jobs()
    for _ in range(2):
        seen = []
        for job in jobs:
            seen.append(job.shot)
            # Each look goes over all that the process holds.
            assert job.shot % 100 or held_jobs() <= others + 2
        assert seen == numbers


def held_jobs() -> int:
    return sum(isinstance(held, ShotJob) for held in gc.get_objects())


def test_the_exposure_of_a_shot_stands_in_its_row(folder: Path, tmp_path: Path) -> None:
    home = tmp_path / "other"
    home.mkdir()
    shutil.copy(folder / "campaign.toml", home)
    (home / "shots.csv").write_text("shot,exposure_us\n1,200\n2,\n")
    exposures = [job.setup.camera.exposure_s for job in read_campaign(home).jobs]
    assert exposures == [pytest.approx(2e-4), None]


def test_frames_without_a_row_are_named_and_other_files_are_not(
    folder: Path, tmp_path: Path
) -> None:
    home = tmp_path / "other"
    frames = home / "frames"
    for name in ("0001", "0007", ".thumbnails"):
        (frames / name).mkdir(parents=True)
    for name in ("0001/0.png", "0007/0.png", "0002.tiff", "0002.json", "3.NPY", "notes.txt"):
        (frames / name).touch()
    shutil.copy(folder / "campaign.toml", home)
    (home / "shots.csv").write_text("shot\n1\n2\n")
    assert read_campaign(home).unlisted == (frames / "0007", frames / "3.NPY")
    assert read_campaign(folder).unlisted == ()


def test_a_folder_of_poses_is_told_from_one_of_frames(written: Path) -> None:
    with pytest.raises(InputError, match="holds poses and no frames; `rigctl model` reads it"):
        read_campaign(written)


def test_one_frame_file_of_a_campaign_keeps_its_number_and_set_up(folder: Path) -> None:
    campaign = read_campaign(folder / "frames" / "0003.tiff")
    (job,) = campaign.jobs
    assert (campaign.name, job.shot) == ("nylon", 3)
    assert job.setup == read_campaign(folder).jobs[2].setup


def test_a_loose_file_takes_the_thesis_s_set_up_or_the_given_one(tmp_path: Path) -> None:
    path = tmp_path / "0042.tiff"
    tifffile.imwrite(path, np.zeros((8, 192, 240), np.uint8), photometric="minisblack")
    assert read_campaign(path).jobs[0].setup == THESIS_SETUP
    given = setup_of(WorldDescription())
    campaign = read_campaign(path, given)
    assert (campaign.name, campaign.jobs[0].shot) == ("0042", 42)
    assert campaign.jobs[0].setup == given


def test_recorded_times_go_before_the_frame_rate(folder: Path, tmp_path: Path) -> None:
    (job, *_) = read_campaign(folder).jobs
    path = tmp_path / "0001.tiff"
    shutil.copy(job.frames, path)
    (moved,) = read_campaign(path, job.setup).jobs
    plain, _ = analyse_job(moved, THESIS)
    times = (5.0 + np.arange(16) / 900.0).tolist()
    path.with_suffix(".json").write_text(json.dumps({"times_s": times}))
    slow, _ = analyse_job(moved, THESIS)
    assert isinstance(plain, MeasuredShot)
    assert isinstance(slow, MeasuredShot)
    assert slow.times_s[-1] == pytest.approx(15 / 900.0)
    assert any("1.111 ms apart" in note and "1 ms by the stated" in note for note in slow.notes)
    assert not any("ms apart" in note for note in plain.notes)
    # Gravity is known and stays; all else goes at 0.9 of the speed.
    assert slow.impact.v_n.value == pytest.approx(0.9 * plain.impact.v_n.value, rel=0.01)


def test_what_could_not_be_checked_about_a_file_stands_in_the_notes(
    folder: Path, tmp_path: Path
) -> None:
    path = tmp_path / "0001.mkv"
    frames = tifffile.imread(folder / "frames" / "0001.tiff")
    size = (frames.shape[2], frames.shape[1])
    video = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"FFV1"), 25.0, size, False)
    for frame in frames:
        video.write(frame)
    video.release()
    # Matroska: Duration, by which frames are counted, becomes Void of the same length.
    path.write_bytes(path.read_bytes().replace(b"\x44\x89\x88", b"\xec\x89\x00"))
    (job,) = read_campaign(path, read_campaign(folder).jobs[0].setup).jobs
    shot, _ = analyse_job(job, AnalysisOptions())
    assert isinstance(shot, MeasuredShot)
    assert "does not say how many frames" in shot.notes[0]


@pytest.mark.parametrize(
    ("name", "reason"),
    [("absent", "no such file or folder"), ("empty", "neither campaign.toml nor PNG or DNG")],
)
def test_what_is_no_campaign_is_refused_by_name(tmp_path: Path, name: str, reason: str) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match=reason) as fault:
        read_campaign(tmp_path / name)
    assert fault.value.path == str(tmp_path / name)


def test_a_sphere_on_a_plate_is_not_measured_from_frames(tmp_path: Path) -> None:
    (tmp_path / "campaign.toml").write_text(
        'format = 1\nname = "drop"\n'
        "camera = { frame_rate_hz = 250, width_px = 240, height_px = 192 }\n"
        'spheres = [{ name = "a", diameter_m = 0.0254 }, { name = "b", plate = true }]\n'
    )
    with pytest.raises(InputError, match="plate; a film of one ball is measured by"):
        read_campaign(tmp_path)


def test_a_written_folder_reads_back_equal_and_says_how_its_poses_err(
    folder: Path, written: Path, results: list[Result]
) -> None:
    name, setup = read_description(folder / "campaign.toml")
    measured = [shot for _, shot in results if isinstance(shot, MeasuredShot)]
    wanted = typical(setup, [shot.slow for shot in measured])
    assert read_description(written / "campaign.toml") == (name, wanted)
    # At 1574.8 px/m: 0.0016 px within its factor of 2, and what all flights share, 0.006 px
    # over the two films that taught (decision 0035).
    slow = read_description(written / "campaign.toml")[1]
    assert 0.0008 < slow.measurement.position_m * 1574.8 < 0.0032
    assert slow.measurement.shared_m == pytest.approx(0.006 / 2 / 1574.8, rel=0.05)
    assert slow.measurement.one_body_frame
    assert read_shot_list(written / "shots.csv") == read_shot_list(folder / "shots.csv")


def test_poses_hold_positions_and_quaternions_of_every_frame(
    written: Path, results: list[Result]
) -> None:
    rows = table(written / "poses.csv")
    assert {row["shot"] for row in rows} == {"1", "3"}
    shot = results[0][1]
    assert isinstance(shot, MeasuredShot)
    for name, centres, turned in zip("ab", shot.centres, shot.orientations, strict=True):
        mine = [row for row in rows if row["shot"] == "1" and row["sphere"] == name]
        assert [int(row["frame"]) for row in mine] == centres.frames.tolist()
        placed = np.array([[float(row[f"{axis}_m"]) for axis in "xyz"] for row in mine])
        np.testing.assert_array_equal(placed, centres.position)
        oriented = [row for row in mine if row["qw"]]
        assert [int(row["frame"]) for row in oriented] == turned.frames.tolist()
        quaternions = np.array([[float(row[f"q{c}"]) for c in "wxyz"] for row in oriented])
        matrices = Rotation.from_quat(quaternions, scalar_first=True).as_matrix()
        np.testing.assert_allclose(matrices, turned.rotation, atol=1e-7)
        assert all(float(row["sigma_rot_rad"]) > 0 for row in oriented)
        assert float(mine[-1]["t_s"]) == pytest.approx(int(mine[-1]["frame"]) * 1e-3)


def test_contacts_hold_the_states_on_both_sides(written: Path, results: list[Result]) -> None:
    rows = table(written / "contacts.csv")
    assert [row["shot"] for row in rows] == ["1", "3"]
    shot = results[2][1]
    assert isinstance(shot, MeasuredShot)
    for column, expected in (
        ("n", shot.impact.normal),
        ("va_", shot.impact.before.velocity_a),
        ("wb_", shot.impact.before.spin_b),
    ):
        np.testing.assert_array_equal(
            [float(rows[1][f"{column}{axis}"]) for axis in "xyz"], expected
        )
    after = [float(rows[1][f"vb_{axis}_after"]) for axis in "xyz"]
    np.testing.assert_array_equal(after, shot.impact.after.velocity_b)
    assert 1e-5 < float(rows[1]["sigma_v_m_per_s"]) < 0.01
    assert 0.01 < float(rows[1]["sigma_w_rad_per_s"]) < 3.0
