"""A shot on tape: nothing may fire before it records, and nothing is lost in silence after."""

from __future__ import annotations

import logging
from typing import Any

import numpy as np
import pytest

from rigctl.cameras.frames import FrameSequence
from rigctl.cameras.keypad import Keypad
from rigctl.cameras.tape import TapeCapture
from rigctl.config import EktaproCamera, EktaproLink, FilesSource
from rigctl.devices.ektapro import RecordingFormat
from rigctl.errors import (
    DeviceAnswerError,
    DeviceSilentError,
    FramesError,
    RecordingNotConfirmedError,
    RefusedError,
    TapeFullError,
)

Recorder = Any
Clock = Any


class Contact:
    """The remote trigger: the closing edge starts the tape, the opening edge stops it."""

    name = "contact"

    def __init__(self, recorder: Recorder) -> None:
        self.recorder, self.closed, self.released = recorder, False, 0
        self.cut = False
        self.fails_to_open = False

    def check(self) -> None:
        self.recorder.calls.append("check contact")

    def close_contact(self) -> None:
        if not self.closed and not self.cut:
            self.recorder.run()
        self.closed = True

    def open_contact(self) -> None:
        if self.fails_to_open:
            raise DeviceSilentError("relay", part=self.name)
        if self.closed:
            self.recorder.running = False
            self.recorder.stopped_at = self.recorder.time.now
        self.closed = False

    def close(self) -> None:
        self.released += 1


class Source:
    """Gives what was asked for, less the pictures in `hidden`; those in `lost` are admitted."""

    name = "source"

    def __init__(self) -> None:
        self.asked: list[tuple[int, int, float]] = []
        self.hidden, self.lost = set[int](), tuple[int, ...]()
        self.released = 0

    def check(self) -> None:
        self.asked.append((0, 0, 0.0))

    def fetch(self, first: int, count: int, timeout_s: float) -> FrameSequence:
        self.asked.append((first, count, timeout_s))
        gone = self.hidden | set(self.lost)
        sequence = np.array([n for n in range(first, first + count) if n not in gone])
        pixels = np.random.default_rng(1).integers(0, 256, (len(sequence), 192, 240))
        return FrameSequence(
            pixels.astype(np.uint8), sequence / 1000.0, sequence, self.lost, self.name
        )

    def close(self) -> None:
        self.released += 1


class Bench:
    """A capture with all that it is made of."""

    def __init__(
        self, recorder: Recorder, time: Clock, *, with_contact: bool = True, before: int = 0
    ) -> None:
        self.recorder, self.time, self.source = recorder, time, Source()
        self.contact = Contact(recorder) if with_contact else None
        settings = EktaproCamera(
            kind="ektapro", frame_rate_hz=1000, pictures_per_frame=1, rows=192, columns=240,
            start_timeout_s=3.0, collect_timeout_s=10.0, frames_before_mark=before,
            frames_after_mark=60,
            recorder=EktaproLink(driver="ektapro-link", port="x", answer_timeout_s=0.5),
            source=FilesSource(driver="files", folder="x"),
        )  # fmt: skip
        self.capture = TapeCapture(
            settings, recorder=recorder, source=self.source, contact=self.contact,
            clock=time.clock, wait=time.wait,
        )  # fmt: skip


@pytest.fixture
def bench(recorder: Recorder, time: Clock) -> Bench:
    return Bench(recorder, time)


def test_a_shot_starts_confirmed_and_brings_the_pictures_from_its_mark_on(bench: Bench) -> None:
    confirmation = bench.capture.start()
    assert confirmation.by == "recorder"
    assert confirmation.evidence.startswith("session 1: ")
    bench.time.now += 0.5
    bench.capture.mark()
    mark = bench.recorder.marked[0]
    frames = bench.capture.collect()
    assert frames.sequence.tolist() == list(range(mark, mark + 60))
    assert not bench.recorder.running
    assert not bench.contact.closed


def test_frames_before_the_mark_are_recorded_before_the_start_is_confirmed(
    recorder: Recorder, time: Clock
) -> None:
    bench = Bench(recorder, time, before=100)
    bench.capture.start()
    assert recorder.pictures() > 100
    bench.capture.mark()
    mark = recorder.marked[0]
    assert bench.capture.collect().sequence.tolist() == list(range(mark - 100, mark + 60))


def test_a_marker_that_came_late_is_counted_back_to_the_fire(bench: Bench) -> None:
    bench.capture.start()
    bench.time.now += 0.5
    bench.capture.mark(late_s=0.040)
    fired = bench.recorder.marked[0] - 40
    assert bench.capture.collect().sequence.tolist() == list(range(fired, fired + 60))


@pytest.mark.parametrize("on_the_way_ms", [0, 4, 40, 300])
def test_a_marker_that_reached_the_recorder_late_leaves_the_fire_in_the_window(
    bench: Bench, on_the_way_ms: int
) -> None:
    bench.capture.start()
    bench.time.now += 0.5
    fired = bench.recorder.pictures()
    bench.recorder.mark_takes_s = on_the_way_ms / 1000
    bench.capture.mark()
    pictures = bench.capture.collect().sequence
    assert pictures[0] <= fired + 10
    assert pictures[-1] >= fired + 58


def test_a_window_made_longer_by_a_slow_link_begins_no_earlier_than_the_tape(
    recorder: Recorder, time: Clock
) -> None:
    bench = Bench(recorder, time, before=100)
    bench.capture.start()
    recorder.mark_takes_s = 0.4
    since_start = recorder.pictures()
    bench.capture.mark(late_s=(since_start - 85) / 1000)
    assert bench.capture.collect().sequence[0] == 0


def test_without_a_contact_the_link_starts_the_tape(recorder: Recorder, time: Clock) -> None:
    bench = Bench(recorder, time, with_contact=False)
    bench.capture.start()
    assert "record" in recorder.calls
    bench.capture.stop()
    assert not recorder.running


def test_a_tape_that_never_starts_is_not_confirmed_within_its_bound_and_is_stopped(
    bench: Bench,
) -> None:
    bench.recorder.starts = False
    with pytest.raises(RecordingNotConfirmedError, match="STOP, 0 pictures"):
        bench.capture.start()
    assert bench.time.now == pytest.approx(1003.0, abs=0.02)
    assert not bench.contact.closed


def test_a_count_that_does_not_rise_is_no_confirmation(bench: Bench) -> None:
    bench.recorder.ends_after = 1
    with pytest.raises(RecordingNotConfirmedError, match="rising count"):
        bench.capture.start()


def test_another_format_than_configured_is_no_confirmation(bench: Bench) -> None:
    bench.recorder.granted = RecordingFormat(1000, 96)
    with pytest.raises(RecordingNotConfirmedError, match="96 rows"):
        bench.capture.start()


def test_a_full_tape_refuses_with_the_question_and_keeps_what_is_on_it(bench: Bench) -> None:
    bench.recorder.left_s = 3.0
    for ask in (bench.capture.check, bench.capture.start):
        with pytest.raises(TapeFullError, match=r"erase all its sessions\?.*rigctl recorder erase"):
            ask()
    assert "erase" not in bench.recorder.calls
    assert not bench.recorder.running


def test_a_full_tape_is_erased_where_the_operator_agreed_and_the_confirmation_says_so(
    bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    bench.recorder.left_s = 3.0
    bench.capture.erases_when_full = True
    bench.capture.check()
    with caplog.at_level(logging.WARNING):
        confirmation = bench.capture.start()
    assert "erase" in bench.recorder.calls
    assert "sessions [1]" in caplog.text
    assert "sessions [1] were erased, as agreed" in confirmation.evidence


def test_of_many_erased_sessions_the_first_and_the_last_are_named(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench.recorder.left_s = 3.0
    bench.capture.erases_when_full = True
    monkeypatch.setattr(bench.recorder, "sessions", lambda: dict.fromkeys(range(1, 425), 60))
    evidence = bench.capture.start().evidence
    assert "sessions 1 to 424 (424 of them) were erased, as agreed" in evidence


def test_the_keypad_has_the_recorder_before_and_after_a_shot_and_never_during_it(
    bench: Bench,
) -> None:
    keypad = Keypad(bench.capture)
    keypad.stop()
    bench.capture.start()
    for key in (keypad.stop, keypad.erase, keypad.status):
        with pytest.raises(RefusedError, match="shot under way"):
            key()
    bench.capture.mark()
    bench.capture.collect()
    with pytest.raises(RefusedError):
        keypad.stop()
    bench.capture.stop()
    keypad.stop()


def test_a_gamma_that_somebody_looked_with_is_gone_when_a_shot_starts(bench: Bench) -> None:
    Keypad(bench.capture).gamma(0.4)
    bench.capture.start()
    assert bench.recorder.exponent == 1.0


def test_a_tape_with_room_is_not_erased(bench: Bench) -> None:
    bench.capture.start()
    assert "erase" not in bench.recorder.calls


def test_a_tape_that_is_too_short_even_when_erased_is_no_confirmation(bench: Bench) -> None:
    bench.recorder.left_s = bench.recorder.left_after_erase_s = 3.0
    bench.capture.erases_when_full = True
    with pytest.raises(RecordingNotConfirmedError, match="too short"):
        bench.capture.start()


def test_a_marker_whose_answer_was_lost_is_found_on_the_tape(bench: Bench) -> None:
    bench.recorder.mark_is_answered = False
    bench.capture.start()
    bench.capture.mark()
    assert len(bench.capture.collect().sequence) == 60
    assert bench.recorder.calls.count("mark") == 1


def test_a_recording_without_marker_is_an_error_and_the_tape_is_stopped(bench: Bench) -> None:
    bench.recorder.refuses.add("mark")
    bench.capture.start()
    bench.capture.mark()
    with pytest.raises(FramesError, match="no marker"):
        bench.capture.collect()
    assert not bench.recorder.running


def test_a_tape_that_ends_within_the_shot_is_an_error(bench: Bench) -> None:
    bench.capture.start()
    bench.capture.mark()
    bench.recorder.ends_after = bench.recorder.marked[0] + 30
    with pytest.raises(FramesError, match="ended before the last picture"):
        bench.capture.collect()


def test_a_recording_that_was_begun_anew_is_an_error(bench: Bench) -> None:
    bench.capture.start()
    bench.capture.mark()
    marks = bench.recorder.marked
    bench.recorder.run()
    bench.recorder.marked = marks
    with pytest.raises(FramesError, match=r"session 2, allowed session 1"):
        bench.capture.collect()


def test_a_picture_missing_without_a_word_is_an_error(bench: Bench) -> None:
    bench.capture.start()
    bench.capture.mark()
    bench.source.hidden = {bench.recorder.marked[0] + 7}
    with pytest.raises(FramesError, match="missing without a word"):
        bench.capture.collect()


def test_a_picture_that_is_reported_lost_stays_reported(bench: Bench) -> None:
    bench.capture.start()
    bench.capture.mark()
    bench.source.lost = (bench.recorder.marked[0] + 7,)
    assert bench.capture.collect().lost == bench.source.lost


def test_the_source_gets_only_the_time_that_is_left(bench: Bench) -> None:
    bench.capture.start()
    bench.capture.mark()
    before = bench.time.now
    bench.capture.collect()
    assert bench.source.asked[-1][2] == pytest.approx(10.0 - (bench.time.now - before))


def test_stopping_tries_the_tape_even_when_the_contact_fails(bench: Bench) -> None:
    bench.capture.start()
    bench.contact.fails_to_open = True
    with pytest.raises(DeviceSilentError):
        bench.capture.stop()
    assert bench.recorder.calls[-1] == "stop"
    assert not bench.recorder.running


def test_a_device_that_refuses_during_the_start_leaves_no_tape_running(bench: Bench) -> None:
    bench.recorder.refuses.add("rate")
    with pytest.raises(DeviceAnswerError):
        bench.capture.start()
    assert not bench.recorder.running


def test_signs_of_life_are_asked_of_every_part_and_all_are_released(bench: Bench) -> None:
    bench.capture.check()
    assert bench.recorder.calls == ["check contact", "check"]
    assert bench.source.asked
    bench.capture.close()
    assert (bench.contact.released, bench.recorder.closed, bench.source.released) == (1, 1, 1)


def test_one_capture_serves_shot_after_shot_even_after_a_failed_one(bench: Bench) -> None:
    bench.capture.start()
    bench.recorder.refuses.add("marks")
    with pytest.raises(DeviceAnswerError):
        bench.capture.collect()
    bench.recorder.refuses.clear()
    bench.capture.start()
    bench.capture.mark()
    assert len(bench.capture.collect().sequence) == 60
