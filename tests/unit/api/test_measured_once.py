"""What is measured stays measured: by content, method and set-up, in the next process too."""

from __future__ import annotations

import shutil
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigctl
from analysis.campaign import ShotJob, analyse_campaign, read_campaign
from analysis.exchange.folder import folder_writer
from analysis.model.data.gather import gather_poses
from analysis.shot import AnalysisOptions, MeasuredShot
from rigctl.api import measured as frames

ARRAYS = ("shots", "times_s", "position", "position_sigma", "rotation", "rotation_sigma")


@pytest.fixture
def copied(filmed: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(filmed, tmp_path / "copied"))


def measured(campaign: rigctl.Campaign) -> int:
    return campaign.measure(workers=1).now


Analysed = list[tuple[ShotJob, MeasuredShot]]


@pytest.fixture(scope="module")
def analysed(filmed: Path) -> Analysed:
    """Return what the analysis measures, without anything that is kept."""
    done = analyse_campaign(read_campaign(filmed), AnalysisOptions(), workers=1)
    found = [(job, shot) for job, shot, _ in done if isinstance(shot, MeasuredShot)]
    assert len(found) == 3
    return found


@pytest.fixture
def kept(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep what is measured from one test to the next."""
    monkeypatch.setenv("RIGCTL_CACHE", str(tmp_path_factory.getbasetemp() / "kept"))


@pytest.mark.usefixtures("kept")
def test_shots_have_the_coefficients_that_the_analysis_measures(
    filmed: Path, analysed: Analysed
) -> None:
    table = rigctl.open(filmed).measure(workers=1).table()
    for row, (job, shot) in enumerate(analysed):
        assert table["shot"][row] == job.shot
        for name in ("v_n", "v_s", "v_n_after", "v_s_after", "e", "beta"):
            wanted = getattr(shot.impact, name)
            assert table[name][row] == pytest.approx(wanted.value, rel=1e-6), name
            assert table[f"sigma_{name}"][row] == pytest.approx(wanted.sigma, rel=1e-4), name
    np.testing.assert_array_equal(table["offset_mm"], [6.0, 8.0, 10.0])


@pytest.mark.usefixtures("kept")
def test_a_fit_has_the_poses_that_the_analysis_writes(
    filmed: Path, analysed: Analysed, tmp_path: Path
) -> None:
    with folder_writer(tmp_path / "written", "nylon", [job for job, _ in analysed]) as write:
        for job, shot in analysed:
            write(job.shot, shot)
    _, wanted = gather_poses(tmp_path / "written")
    rigctl.open(filmed).measure(workers=1)
    found: Any = rigctl.open(filmed)._source.measured(1)
    assert found.now == 0
    for name in ARRAYS:
        numbers, expected = getattr(found.data, name), getattr(wanted, name)
        np.testing.assert_allclose(numbers, expected, rtol=1e-6, atol=1e-9, err_msg=name)
    for shot, errors in wanted.own_slow.items():
        assert asdict(found.data.own_slow[shot]) == pytest.approx(asdict(errors), rel=1e-6)


def test_no_shot_is_measured_twice_wherever_its_folder_lies(
    filmed: Path, copied: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    campaign = rigctl.open(filmed, method="thesis")
    assert [measured(campaign), measured(campaign)] == [3, 0]

    def refuse(*_: Any) -> None:
        pytest.fail("it is measured again")

    monkeypatch.setattr(frames, "analyse_campaign", refuse)
    assert measured(rigctl.open(copied, method="thesis")) == 0


def test_a_shot_whose_frames_change_is_measured_again_alone(copied: Path) -> None:
    assert measured(rigctl.open(copied, method="thesis")) == 3
    shutil.copy(copied / "frames" / "0001.tiff", copied / "frames" / "0003.tiff")
    assert measured(rigctl.open(copied, method="thesis")) == 0, "these very frames are known"
    content = bytearray((copied / "frames" / "0003.tiff").read_bytes())
    content[20_000] ^= 1
    (copied / "frames" / "0003.tiff").write_bytes(content)
    assert measured(rigctl.open(copied, method="thesis")) == 1


@pytest.mark.long
def test_another_method_or_set_up_is_another_measurement(copied: Path) -> None:
    assert measured(rigctl.open(copied, method="thesis")) == 3
    assert measured(rigctl.open(copied, method="photometric")) == 3
    about = (copied / "campaign.toml").read_text()
    (copied / "campaign.toml").write_text(about.replace("9.80665", "9.81"))
    assert measured(rigctl.open(copied, method="thesis")) == 3


def test_a_lesson_from_other_frames_is_another_measurement(copied: Path) -> None:
    jobs = read_campaign(copied).jobs
    before = frames.shot_keys(jobs, "photometric")
    first = bytearray((copied / "frames" / "0001.tiff").read_bytes())
    first[20_000] ^= 1
    (copied / "frames" / "0001.tiff").write_bytes(first)
    after = frames.shot_keys(jobs, "photometric")
    assert all(before[shot] != after[shot] for shot in (1, 2, 3))


def test_what_an_interrupted_measurement_has_done_is_kept(
    filmed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = frames.measured_document
    seen: list[int] = []

    def interrupted(shot: Any) -> Any:
        seen.append(len(seen))
        if len(seen) == 3:
            raise KeyboardInterrupt
        return whole(shot)

    with monkeypatch.context() as patched:
        patched.setattr(frames, "measured_document", interrupted)
        with pytest.raises(KeyboardInterrupt):
            measured(rigctl.open(filmed, method="thesis"))
    assert measured(rigctl.open(filmed, method="thesis")) == 1


def test_a_damaged_result_is_no_result(filmed: Path, cache: Path) -> None:
    assert measured(rigctl.open(filmed, method="thesis")) == 3
    first, *_ = sorted(cache.rglob("*.json"))
    first.write_text('{"status": "measu')
    assert measured(rigctl.open(filmed, method="thesis")) == 1


def test_a_folder_that_cannot_be_written_keeps_nothing_and_stops_nothing(
    filmed: Path, cache: Path
) -> None:
    cache.write_text("a file in the place of the folder")
    assert measured(rigctl.open(filmed, method="thesis")) == 3


def test_a_refused_shot_is_named_and_the_others_count(copied: Path) -> None:
    broken = copied / "frames" / "0002.tiff"
    broken.write_bytes(broken.read_bytes()[:9_000])
    shots = rigctl.open(copied, method="thesis").measure(workers=1)
    assert len(shots) == 2
    assert "0002.tiff" in shots.left_out[2]
    assert repr(shots) == "<nylon: 2 measured shots, 1 left out>"


def test_without_any_measured_shot_the_first_reason_is_said(copied: Path) -> None:
    for film in (copied / "frames").iterdir():
        film.write_bytes(b"no film")
    with pytest.raises(rigctl.AnalysisInputError, match=r"no shot can be measured; shot 1: frames"):
        rigctl.open(copied).measure(workers=1)


def test_a_folder_of_films_without_a_description_is_a_campaign_too(filmed: Path) -> None:
    shots = rigctl.open(filmed / "frames", setup=filmed / "campaign.toml", method="thesis")
    assert len(shots.measure(workers=1)) == 3
    listed = [filmed / "frames" / f"{k:04d}.tiff" for k in (1, 3)]
    table = rigctl.open(listed, method="thesis").measure(workers=1).table()
    assert list(table["shot"]) == [1, 3]


def test_every_file_that_measuring_loads_is_part_of_the_key() -> None:
    ask = (
        "import sys\n"
        "import analysis.campaign, analysis.photometric.method, rigctl.measuring.stored_poses\n"
        "print(*(name for name in sys.modules if name.startswith('analysis.')))"
    )
    done = subprocess.run([sys.executable, "-c", ask], capture_output=True, text=True, check=True)
    rooms = {name.split(".")[1] for name in done.stdout.split()}
    assert "photometric" in rooms
    assert not rooms & frames.LATER_ROOMS
