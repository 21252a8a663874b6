from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import tifffile
from numpy.typing import NDArray

from simulators.ektapro.digitiser import Digitiser
from simulators.ektapro.faults import FrameFaults
from simulators.ektapro.processor import Transfer
from simulators.ektapro.tape import RecordingFormat

FIRST_S = 50.0


def numbered(time_s: float, rows: int) -> NDArray[np.uint8]:
    """Return a picture whose grey level is its milliseconds after the session's start."""
    return np.full((rows, 240), round((time_s - FIRST_S) * 1000) % 256, np.uint8)


class Bench:
    def __init__(self, folder: Path) -> None:
        self.folder, self.faults = folder, FrameFaults()
        self.digitiser = Digitiser(folder, numbered, self.faults)

    def transfer(self, name: str = "shot", split: int = 1) -> None:
        recording_format = RecordingFormat(1000, split)
        self.digitiser.start(Transfer(name, 40, 10, FIRST_S, recording_format))
        self.digitiser.finish(10.0)

    def told(self, name: str = "shot") -> dict[str, object]:
        return dict(json.loads((self.folder / f"{name}.json").read_text()))

    def pixels(self, name: str = "shot") -> NDArray[np.uint8]:
        return tifffile.imread(self.folder / f"{name}.tiff")


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    bench = Bench(tmp_path / "capture")
    yield bench
    bench.digitiser.close()


def test_a_stack_holds_the_pictures_of_the_recorded_instants(bench: Bench) -> None:
    bench.transfer()
    assert bench.pixels().shape == (10, 192, 240)
    assert bench.pixels().dtype == np.uint8
    assert bench.pixels()[:, 0, 0].tolist() == list(range(40, 50))
    assert bench.told() == {
        "frames": 10,
        "rows": 192,
        "columns": 240,
        "frame_rate_hz": 1000.0,
        "sequence": list(range(40, 50)),
        "times_s": [n / 1000 for n in range(40, 50)],
        "lost": [],
    }
    assert sorted(path.name for path in bench.folder.iterdir()) == ["shot.json", "shot.tiff"]


def test_the_tiff_has_one_page_a_picture(bench: Bench) -> None:
    bench.transfer()
    with tifffile.TiffFile(bench.folder / "shot.tiff") as tiff:
        assert len(tiff.pages) == 10


def test_split_pictures_have_fewer_rows_at_a_higher_rate(bench: Bench) -> None:
    bench.transfer(split=6)
    assert bench.pixels().shape == (10, 32, 240)
    told = bench.told()
    assert (told["rows"], told["frame_rate_hz"]) == (32, 6000.0)


def test_the_json_comes_when_the_tiff_is_whole(bench: Bench) -> None:
    seen: list[int] = []

    def looking(time_s: float, rows: int) -> NDArray[np.uint8]:
        seen.append(len(list(bench.folder.glob("late.*"))))
        return numbered(time_s, rows)

    digitiser = Digitiser(bench.folder, looking, bench.faults)
    digitiser.start(Transfer("late", 0, 5, FIRST_S, RecordingFormat()))
    digitiser.finish(10.0)
    digitiser.close()
    assert seen == [0] * 5
    assert bench.told("late")["frames"] == len(bench.pixels("late")) == 5


def test_no_stack_replaces_another(bench: Bench) -> None:
    bench.transfer()
    with pytest.raises(ValueError, match="shot exists"):
        bench.transfer()


def test_closing_gives_up_what_is_under_way(bench: Bench) -> None:
    inside, release = threading.Event(), threading.Event()

    def slow(time_s: float, rows: int) -> NDArray[np.uint8]:
        inside.set()
        release.wait(60.0)
        return numbered(time_s, rows)

    digitiser = Digitiser(bench.folder, slow, bench.faults)
    digitiser.start(Transfer("slow", 0, 1000, FIRST_S, RecordingFormat()))
    assert inside.wait(60.0)
    closer = threading.Thread(target=digitiser.close)
    closer.start()
    release.set()
    closer.join(60.0)
    assert not closer.is_alive()
    assert list(bench.folder.iterdir()) == []


def test_a_transfer_that_fails_is_told_to_whoever_waits(bench: Bench) -> None:
    def broken(time_s: float, rows: int) -> NDArray[np.uint8]:
        raise RuntimeError("no light")

    digitiser = Digitiser(bench.folder, broken, bench.faults)
    digitiser.start(Transfer("dark", 0, 1, FIRST_S, RecordingFormat()))
    with pytest.raises(RuntimeError, match="no light"):
        digitiser.finish(10.0)
    digitiser.close()


def test_missing_frames_are_left_out_and_named(bench: Bench) -> None:
    bench.faults.set("missing-frames", times=1, frames=2)
    bench.transfer()
    told = bench.told()
    assert told["sequence"] == [40, 41, 42, 43, 44, 47, 48, 49]
    assert told["lost"] == [45, 46]
    assert told["frames"] == 8
    assert bench.pixels()[:, 0, 0].tolist() == told["sequence"]


def test_a_short_stack_holds_less_than_its_json_says(bench: Bench) -> None:
    bench.faults.set("short-stack", times=1)
    bench.transfer()
    assert bench.told()["frames"] == 10
    assert len(bench.pixels()) == 9


def test_an_extra_frame_repeats_one_picture_and_its_number(bench: Bench) -> None:
    bench.faults.set("extra-frame", times=1)
    bench.transfer()
    numbers = [40, 41, 42, 43, 44, 45, 45, 46, 47, 48, 49]
    assert bench.told()["sequence"] == numbers
    assert bench.pixels()[:, 0, 0].tolist() == numbers


def test_a_frozen_camera_shows_the_first_picture_throughout(bench: Bench) -> None:
    bench.faults.set("frozen", times=1)
    bench.transfer()
    assert np.unique(bench.pixels()).tolist() == [40]
    assert bench.told()["sequence"] == list(range(40, 50))


def test_a_wrong_size_is_half_the_columns(bench: Bench) -> None:
    bench.faults.set("wrong-size", times=1)
    bench.transfer()
    assert bench.pixels().shape == (10, 192, 120)
    assert bench.told()["columns"] == 120


def test_a_truncated_tiff_breaks_off(bench: Bench) -> None:
    bench.transfer("whole")
    bench.faults.set("truncated-tiff", times=1)
    bench.transfer("cut")
    size = (bench.folder / "whole.tiff").stat().st_size
    assert (bench.folder / "cut.tiff").stat().st_size == size // 2
    assert bench.told("cut")["frames"] == 10


def test_no_frames_means_no_files(bench: Bench) -> None:
    bench.faults.set("no-frames", times=1)
    bench.transfer()
    assert list(bench.folder.iterdir()) == []


def test_a_counted_fault_strikes_so_many_transfers_and_a_cleared_one_none(bench: Bench) -> None:
    bench.faults.set("frozen", times=2)
    levels = []
    for name in "abc":
        bench.transfer(name)
        levels.append(len(np.unique(bench.pixels(name))))
    assert levels == [1, 1, 10]
    bench.faults.set("frozen")
    bench.faults.clear()
    bench.transfer("d")
    assert len(np.unique(bench.pixels("d"))) == 10


@pytest.mark.parametrize("bad", [{"kind": "burn"}, {"kind": "frozen", "frames": 0}])
def test_a_fault_that_cannot_be_is_refused(bad: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=r"none of|allowed"):
        FrameFaults().set(**bad)  # type: ignore[arg-type]
