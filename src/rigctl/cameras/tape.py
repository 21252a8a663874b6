"""A shot on tape: recording confirmed before the fire, pictures brought from it afterwards."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Collection, Iterator
from contextlib import ExitStack, contextmanager
from typing import Protocol

from rigctl.cameras.capture import RecordingConfirmation
from rigctl.cameras.checks import Expected, check_frames
from rigctl.cameras.frames import FrameSequence
from rigctl.config import EktaproCamera
from rigctl.devices.ektapro import EktaproLink, RecorderMode, RecorderStatus, RecordingFormat
from rigctl.devices.roles import Closure
from rigctl.errors import (
    DeviceError,
    FramesError,
    RecordingNotConfirmedError,
    RefusedError,
    TapeFullError,
)

_log = logging.getLogger(__name__)

_POLL_S = 0.005
_LONGEST_POLL_S = 0.1
_USUAL_DELAY_S = 0.01
"""A marker that is answered within this time lies near enough to when it was sent."""
_MOST_LISTED = 6
"""Sessions that a message names one by one."""
_RESERVE_S = 5.0
"""Tape kept for what passes between the confirmed recording and the fire."""


class PictureSource(Protocol):
    """Brings pictures of the recorder's present session into memory."""

    @property
    def name(self) -> str:
        """Where the pictures come from."""

    def check(self) -> None:
        """Raise a `RigError` when the source is not there."""

    def fetch(self, first: int, count: int, timeout_s: float) -> FrameSequence:
        """Bring `count` pictures from number `first`, or raise within the time."""

    def close(self) -> None:
        """Release the source. Safe to call twice."""


class TapeCapture:
    """A `Capture` on the EktaPro 1000: the tape holds nothing from before it was told to record.

    The picture numbers of a shot are `mark` - `frames_before_mark` to `mark` +
    `frames_after_mark` - 1, where the mark is the picture under way when the rig fired: the event
    marker on the tape less the pictures by which it came late. Where the recorder answered late,
    the marker was set anywhere within that delay: so many pictures more are brought from before,
    as far back as the tape goes.

    A tape without room for another shot refuses to arm and asks the operator. It is erased when
    somebody asks for it, or by the next recording where the operator agreed (`erases_when_full`).

    Attributes
    ----------
    erases_when_full
        Whether the operator has agreed; what was erased stands in the confirmation.

    Parameters
    ----------
    settings
        Rate, format, window about the mark and time limits.
    recorder
        Link to the recorder.
    source
        Where its pictures come from.
    contact
        The remote trigger that starts the tape; None starts it by the link.
    clock, wait
        Monotonic seconds, and a wait in seconds.
    """

    def __init__(
        self,
        settings: EktaproCamera,
        *,
        recorder: EktaproLink,
        source: PictureSource,
        contact: Closure | None,
        clock: Callable[[], float] = time.monotonic,
        wait: Callable[[float], None] = time.sleep,
    ) -> None:
        self._settings, self._recorder, self._source = settings, recorder, source
        self._contact, self._clock, self._wait = contact, clock, wait
        self._session: int | None = None
        self._late = 0
        self._more = 0
        self._turn = threading.Lock()
        self._shooting = False
        self.erases_when_full = settings.when_full == "erase"

    @property
    def settings(self) -> EktaproCamera:
        """What it is set to."""
        return self._settings

    @property
    def source(self) -> PictureSource:
        """Where its pictures come from."""
        return self._source

    @property
    def needed_s(self) -> float:
        """Recording time on the tape that a shot must find, s."""
        after_s = self._settings.frames_after_mark / self._settings.picture_rate_hz
        return self._settings.start_timeout_s + _RESERVE_S + after_s

    @contextmanager
    def between_shots(self) -> Iterator[EktaproLink]:
        """Give the recorder to the keypad; no shot begins meanwhile.

        Raises
        ------
        RefusedError
            A shot is being recorded or fetched.
        """
        with self._turn:
            if self._shooting:
                raise RefusedError(
                    "the recorder belongs to the shot under way", todo="wait for the shot's end"
                )
            yield self._recorder

    @property
    def name(self) -> str:
        """Recorder and frame source."""
        return f"{self._recorder.name}, {self._source.name}"

    def check(self) -> None:
        """Ask remote trigger, recorder and source for a sign of life."""
        if self._contact is not None:
            self._contact.check()
        self._recorder.check()
        self._source.check()
        if not self.erases_when_full:
            self._require_room(self._recorder.status().seconds_left)

    def start(self) -> RecordingConfirmation:
        """Start the tape; return once it records and its picture count rises.

        Raises
        ------
        RecordingNotConfirmedError
            The recorder did not record within `start_timeout_s`, has not the format, or no tape.
        TapeFullError
            The tape has no room for a shot, and nobody has agreed to erase it.
        DeviceError
            A device refused or gave no answer. The tape is stopped, as far as it can be.
        """
        with self._turn:
            self._shooting = True
        self._session = None
        self._halt()
        self._set_format()
        erased = self._make_room()
        try:
            if self._contact is None:
                self._recorder.record()
            else:
                self._contact.close_contact()
            return self._confirmed(erased)
        except Exception:
            self._stop_quietly()
            raise

    def mark(self, late_s: float = 0.0) -> None:
        """Put an event marker on the picture being recorded, `late_s` after the fire.

        A marker without an answer is logged, not raised: the shot has been fired, and `collect`
        asks the recorder for its markers.
        """
        sent_at = self._clock()
        try:
            self._recorder.mark()
        except DeviceError as error:
            _log.warning("%s: the marker is in doubt: %s", self.name, error)
        rate = self._settings.picture_rate_hz
        answer_s = self._clock() - sent_at
        self._late = round(late_s * rate)
        self._more = max(0, round((answer_s - _USUAL_DELAY_S) * rate))

    def collect(self) -> FrameSequence:
        """Wait for the pictures after the mark, stop the tape, and bring those about the mark.

        Raises
        ------
        FramesError
            There is no marker, the recording ended early, or the pictures did not come whole and
            in time.
        DeviceError
            A device refused or gave no answer.
        """
        deadline = self._clock() + self._settings.collect_timeout_s
        try:
            expected = self._window()
            recorded = self._recorded(expected, deadline)
        finally:
            self._stop_quietly()
        if recorded < expected.first + expected.count:
            raise FramesError(
                "the recording ended before the last picture of the shot",
                part=self.name,
                value=f"{recorded} pictures",
                limit=f"{expected.first + expected.count} pictures",
                todo="check tape and remote trigger, or ask for fewer frames after the mark",
            )
        left_s = max(0.0, deadline - self._clock())
        frames = self._source.fetch(expected.first, expected.count, left_s)
        check_frames(frames, expected)
        return frames

    def stop(self) -> None:
        """End a shot: open the contact, stop the tape; each is tried even when the other fails."""
        try:
            self._halt()
        finally:
            self._shooting = False

    def _halt(self) -> None:
        with ExitStack() as both:
            both.callback(self._recorder.stop)
            if self._contact is not None:
                both.callback(self._contact.open_contact)

    def close(self) -> None:
        """Release contact, recorder and source. Safe to call twice."""
        with ExitStack() as all_three:
            all_three.callback(self._source.close)
            all_three.callback(self._recorder.close)
            if self._contact is not None:
                all_three.callback(self._contact.close)

    def _set_format(self) -> None:
        if self._recorder.has_gamma:
            self._recorder.set_gamma(1.0)
        wanted = RecordingFormat(round(self._settings.picture_rate_hz), self._settings.rows)
        granted = self._recorder.set_rate(
            self._settings.frame_rate_hz, self._settings.pictures_per_frame
        )
        if granted != wanted:
            raise RecordingNotConfirmedError(
                "the recorder has another format",
                part=self.name,
                value=f"{granted.pictures_per_s} pictures/s of {granted.rows} rows",
                limit=f"{wanted.pictures_per_s} pictures/s of {wanted.rows} rows",
                todo="correct rate, pictures per frame and rows in the configuration",
            )

    def _require_room(self, left_s: float) -> None:
        if left_s < self.needed_s:
            raise TapeFullError(
                "the tape has no room for another shot: erase all its sessions?",
                part=self.name,
                value=f"{left_s:.1f} s left",
                limit=f"{self.needed_s:.1f} s",
                todo="erase it with `rigctl recorder erase` or on the page Recorder, or agree to "
                'it in advance with when_full = "erase" under [camera]',
            )

    def _make_room(self) -> str:
        """Erase a tape without room where the operator agreed; say what was lost, or nothing."""
        left_s = self._recorder.status().seconds_left
        if left_s >= self.needed_s:
            return ""
        if not self.erases_when_full:
            self._require_room(left_s)
        lost = _listed(self._recorder.sessions())
        _log.warning("%s: erasing sessions %s, as agreed", self.name, lost)
        self._recorder.erase()
        left_s = self._recorder.status().seconds_left
        if left_s < self.needed_s:
            raise RecordingNotConfirmedError(
                "an erased tape is too short for one shot",
                part=self.name,
                value=f"{left_s:g} s",
                limit=f"{self.needed_s:g} s",
                todo="choose a lower rate or fewer frames after the mark",
            )
        return f" (before it sessions {lost} were erased, as agreed)"

    def _confirmed(self, erased: str) -> RecordingConfirmation:
        deadline = self._clock() + self._settings.start_timeout_s
        before: RecorderStatus | None = None
        while True:
            now = self._recorder.status()
            if now.mode is RecorderMode.RECORD:
                enough = now.pictures > self._settings.frames_before_mark
                if before is not None and enough and now.pictures > before.pictures:
                    self._session = now.session
                    counts = f"{before.pictures}, then {now.pictures} pictures"
                    evidence = f"session {now.session}: {counts}{erased}"
                    return RecordingConfirmation(self._recorder.name, self._clock(), evidence)
                before = before or now
            if self._clock() >= deadline:
                raise self._not_confirmed(now)
            self._wait(_POLL_S)

    def _not_confirmed(self, now: RecorderStatus) -> RecordingNotConfirmedError:
        return RecordingNotConfirmedError(
            "the recorder does not record",
            part=self.name,
            value=f"{now.mode}, {now.pictures} pictures, tape at {now.place}",
            limit=f"RECORD with rising count within {self._settings.start_timeout_s:g} s",
            todo="check the remote trigger's cable, the tape and its run-up",
        )

    def _window(self) -> Expected:
        marks = self._recorder.marks()
        if not marks:
            raise FramesError(
                "the recording carries no marker of the fire",
                part=self.name,
                todo="look for the shot on the tape by hand; the marker's answer is in the log",
            )
        first = marks[0] - self._late - self._settings.frames_before_mark
        if first < 0:
            raise FramesError(
                "the tape holds too few pictures before the mark",
                part=self.name,
                value=f"{marks[0] - self._late} pictures",
                limit=f"{self._settings.frames_before_mark} pictures",
                todo="ask for fewer frames before the mark",
            )
        more = min(self._more, first)
        count = self._settings.frames_before_mark + self._settings.frames_after_mark
        return Expected(first - more, count + more, self._settings.rows, self._settings.columns)

    def _recorded(self, expected: Expected, deadline: float) -> int:
        while True:
            now = self._recorder.status()
            if now.session != self._session:
                raise FramesError(
                    "the recording was broken off and another one begun",
                    part=self.name,
                    value=f"session {now.session}",
                    limit=f"session {self._session}",
                    todo="check the remote trigger's contact",
                )
            missing = expected.first + expected.count - now.pictures
            if missing <= 0 or now.mode is not RecorderMode.RECORD or self._clock() >= deadline:
                return now.pictures
            wait_s = missing / self._settings.picture_rate_hz
            self._wait(min(max(wait_s, _POLL_S), _LONGEST_POLL_S))

    def _stop_quietly(self) -> None:
        try:
            self._halt()
        except DeviceError as error:
            _log.warning("%s: the tape may still run: %s", self.name, error)


def _listed(sessions: Collection[int]) -> str:
    """Return the numbers of sessions, of many the first and the last."""
    numbers = list(sessions)
    if len(numbers) <= _MOST_LISTED:
        return str(numbers)
    return f"{numbers[0]} to {numbers[-1]} ({len(numbers)} of them)"
