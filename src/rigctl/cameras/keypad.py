"""The recorder's keypad: look, record, play, search and erase between shots."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from rigctl.cameras.frames import FrameSequence
from rigctl.cameras.tape import TapeCapture
from rigctl.devices.ektapro import EktaproLink, RecorderMode, RecorderStatus, TapePlace
from rigctl.errors import DeviceAnswerError, SettingsError

SLOWEST, FASTEST = 1, 30
"""Pictures a second of a replay that is not the recorder's own."""
LEAST_GAMMA, MOST_GAMMA = 0.1, 1.0
"""Thesis, appendix A."""
_STILL_TIMEOUT_S = 5.0
_POLL_S = 0.02
_PLAYABLE = frozenset({RecorderMode.REPLAY, RecorderMode.PLAY, RecorderMode.JOG,
                       RecorderMode.SEARCH, RecorderMode.STOP})  # fmt: skip


@dataclass(frozen=True, slots=True)
class KeypadStatus:
    """What the recorder does, and what is on its tape.

    Attributes
    ----------
    session, pictures
        The session that is recorded or selected (0: none), and how many pictures it holds.
    picture, picture_s
        On which picture playback stands, and its time from the session's first, s; None where
        nothing can be shown.
    marks
        Marked pictures of the session.
    sessions
        Pictures of each session on the tape.
    seconds_left, needed_s
        Recording time left, and what a shot needs, s.
    gamma
        Exponent of the grey levels; None on a recorder that knows none.
    erases_when_full
        Whether the operator agreed that a tape without room is erased by the next shot.
    """

    mode: RecorderMode
    session: int
    pictures: int
    picture: int | None
    picture_s: float | None
    marks: tuple[int, ...]
    sessions: dict[int, int]
    seconds_left: float
    needed_s: float
    place: TapePlace
    gamma: float | None
    erases_when_full: bool


class Keypad:
    """The keys of a tape recorder. None of them acts while a shot is recorded or fetched.

    Every method raises `RefusedError` during a shot and a `DeviceError` where the recorder refuses
    or is silent. Times count at the rate of the configuration, at which this program records.
    """

    def __init__(self, tape: TapeCapture) -> None:
        self._tape, self._rate = tape, tape.settings.picture_rate_hz

    @property
    def name(self) -> str:
        """Recorder and source."""
        return self._tape.name

    def status(self) -> KeypadStatus:
        """Return what the recorder does and what is on its tape."""
        with self._tape.between_shots() as recorder:
            recorder.check()
            now = recorder.status()
            picture = self._picture(recorder, now)
            return KeypadStatus(
                mode=now.mode,
                session=now.session,
                pictures=now.pictures,
                picture=picture,
                picture_s=None if picture is None else picture / self._rate,
                marks=recorder.marks(),
                sessions=recorder.sessions(),
                seconds_left=now.seconds_left,
                needed_s=self._tape.needed_s,
                place=now.place,
                gamma=recorder.gamma() if recorder.has_gamma else None,
                erases_when_full=self._tape.erases_when_full,
            )

    def live(self) -> None:
        """Show the live image; a recording ends."""
        self._press(lambda recorder: recorder.live())

    def record(self) -> None:
        """Record a session at the configured rate, until `stop` or the tape's end."""
        settings = self._tape.settings

        def press(recorder: EktaproLink) -> None:
            if recorder.status().mode not in {RecorderMode.LIVE, RecorderMode.STOP}:
                recorder.stop()
            recorder.set_rate(settings.frame_rate_hz, settings.pictures_per_frame)
            recorder.record()

        self._press(press)

    def stop(self) -> None:
        """End recording or playback on the present picture."""
        self._press(lambda recorder: recorder.stop())

    def replay(self) -> None:
        """Play the latest session from its first picture, 30 pictures a second."""
        self._press(lambda recorder: recorder.replay())

    def play(self) -> None:
        """Play on from the present picture, 30 pictures a second."""
        self._press(lambda recorder: recorder.play())

    def jog(self, speed: int) -> None:
        """Play on at a speed of 1 to 30 pictures a second, backwards when it is negative."""
        if not SLOWEST <= abs(speed) <= FASTEST:
            raise SettingsError(
                "the recorder has no such speed",
                part="speed",
                value=f"{speed} pictures/s",
                limit=f"{SLOWEST} to {FASTEST} pictures/s, negative for backwards",
                todo="choose another speed",
            )
        self._press(lambda recorder: recorder.jog(speed))

    def step(self, by: int) -> None:
        """Show the next picture (+1) or the one before (-1)."""
        if by not in {-1, 1}:
            raise SettingsError("is no step", part="by", value=str(by), limit="-1 or 1")
        self._press(lambda recorder: recorder.step(by))

    def search(
        self,
        *,
        session: int | None = None,
        mark: int | None = None,
        frame: int | None = None,
        time_s: float | None = None,
    ) -> None:
        """Wind to a session's first picture, or to a mark, a frame or a time of a session.

        Marks count from 1, frames from 0, the time from the session's first picture.

        Raises
        ------
        SettingsError
            Nothing is named, or more than one place, or a mark that the session has not.
        """
        places = [place for place in (mark, frame, time_s) if place is not None]
        if len(places) > 1 or (not places and session is None):
            raise SettingsError(
                "name a session, and at most one of mark, frame and time", part="search"
            )

        def press(recorder: EktaproLink) -> None:
            if session is not None:
                recorder.select_session(session)
            if mark is not None:
                recorder.search(_marked(recorder, mark))
            elif frame is not None:
                recorder.search(frame)
            elif time_s is not None:
                recorder.search(round(time_s * self._rate))

        self._press(press)

    def gamma(self, exponent: float) -> None:
        """Set the exponent of the grey levels to look at; a shot sets it back to 1.

        Raises
        ------
        SettingsError
            It lies outside 0.1 to 1.0, or the recorder has no gamma.
        """
        if not LEAST_GAMMA <= exponent <= MOST_GAMMA:
            limit = f"{LEAST_GAMMA} to {MOST_GAMMA}"
            raise SettingsError(
                "the recorder has no such gamma", part="gamma", value=f"{exponent:g}", limit=limit
            )

        def press(recorder: EktaproLink) -> None:
            if not recorder.has_gamma:
                raise DeviceAnswerError(
                    "this recorder's link is of version 1, which knows no gamma",
                    part=recorder.name,
                    todo="bring the adapter to version 2",
                )
            recorder.set_gamma(exponent)

        self._press(press)

    def erase(self) -> dict[int, int]:
        """Erase the whole tape; return the pictures of each session that was lost."""
        with self._tape.between_shots() as recorder:
            lost = recorder.sessions()
            if recorder.status().mode not in {RecorderMode.LIVE, RecorderMode.STOP}:
                recorder.stop()
            recorder.erase()
        return lost

    def agree(self, *, erases_when_full: bool) -> None:
        """Agree that a shot erases a tape without room for it, until the daemon ends; or not."""
        self._tape.erases_when_full = erases_when_full

    def still(self) -> FrameSequence:
        """Stop playback and return the picture on which it stands; a search ends first.

        Raises
        ------
        FramesError
            It did not come.
        """
        with self._tape.between_shots() as recorder:
            deadline = time.monotonic() + _STILL_TIMEOUT_S
            while recorder.status().mode is RecorderMode.SEARCH and time.monotonic() < deadline:
                time.sleep(_POLL_S)
            if recorder.status().mode not in {RecorderMode.LIVE, RecorderMode.STOP}:
                recorder.stop()
            return self._tape.source.fetch(recorder.picture(), 1, _STILL_TIMEOUT_S)

    def _press(self, key: Callable[[EktaproLink], object]) -> None:
        with self._tape.between_shots() as recorder:
            recorder.check()
            key(recorder)

    def _picture(self, recorder: EktaproLink, now: RecorderStatus) -> int | None:
        return recorder.picture() if now.mode in _PLAYABLE and now.pictures else None


def _marked(recorder: EktaproLink, mark: int) -> int:
    marks = recorder.marks()
    if not 1 <= mark <= len(marks):
        raise SettingsError(
            "the session has no such mark",
            part="mark",
            value=str(mark),
            limit=f"1 to {len(marks)}" if marks else "none: the session has no mark",
        )
    return marks[mark - 1]
