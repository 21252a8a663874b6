"""The link to the tape recorder: its commands as methods, its answers as values."""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import StrEnum

from rigctl.devices.serial_port import SerialPort
from rigctl.errors import DeviceAnswerError

LONGEST_LINE = 1 << 18
"""Bytes of an answer; that to `SESSIONS?` has some eight for each session, and a tape holds 30000
of a single picture."""

GAMMA_SINCE = 2
"""Version of the link from which it knows a gamma."""


class RecorderMode(StrEnum):
    """What the recorder does."""

    LIVE = "LIVE"
    STARTING = "STARTING"
    RECORD = "RECORD"
    STOP = "STOP"
    REPLAY = "REPLAY"
    PLAY = "PLAY"
    JOG = "JOG"
    SEARCH = "SEARCH"


class TapePlace(StrEnum):
    """Where the tape stands: at its beginning, between, or at its end."""

    BEGINNING = "BOT"
    MIDDLE = "MID"
    END = "EOT"


@dataclass(frozen=True, slots=True)
class RecorderStatus:
    """The answer to `STATUS?`.

    Attributes
    ----------
    pictures
        Recorded in this session so far; the last one has the number `pictures` - 1.
    seconds_left
        Recording time left on the tape at the present rate.
    """

    mode: RecorderMode
    session: int
    pictures: int
    seconds_left: float
    place: TapePlace


@dataclass(frozen=True, slots=True)
class RecordingFormat:
    """What the recorder granted: pictures per second, and the rows of each."""

    pictures_per_s: int
    rows: int


_N = r"\d{1,9}"
_PICTURE = rf"OK PICTURE ({_N})"
_ANSWERS = {
    kind: re.compile(pattern, re.ASCII)
    for kind, pattern in {
        "ID?": r"OK EKTAPRO-SIM ([12])",
        "RATE": rf"OK ({_N}) ({_N})",
        "LIVE": r"OK LIVE",
        "RECORD": rf"OK RECORD ({_N})",
        "STOP": r"OK STOP",
        "STATUS?": rf"OK ({'|'.join(RecorderMode)}) ({_N}) ({_N}) ({_N}(?:\.\d+)?) "
        rf"({'|'.join(TapePlace)})",
        "MARK": rf"OK MARK ({_N})",
        "MARKS?": rf"OK((?: {_N})*)",
        "SESSION": rf"OK SESSION ({_N}) ({_N})",
        "SESSIONS?": rf"OK((?: {_N}:{_N})*)",
        "REPLAY": r"OK REPLAY",
        "PLAY": r"OK PLAY",
        "STEP": _PICTURE,
        "JOG": r"OK JOG",
        "SEARCH": _PICTURE,
        "PICTURE?": _PICTURE,
        "TRANSFER": rf"OK TRANSFER ({_N}) (\S+)",
        "ERASE": r"OK BOT",
        "GAMMA": r"OK GAMMA ([01]\.\d\d)",
        "GAMMA?": r"OK GAMMA ([01]\.\d\d)",
    }.items()
}


class EktaproLink:
    """Client of the recorder link (wire-protocol reference; it is not Kodak's protocol).

    Every method raises `DeviceAnswerError` when the recorder refuses and the other device errors
    when it gives no whole answer in time. Pictures are numbered from 0 in each session.
    """

    def __init__(self, port: SerialPort) -> None:
        self._port = port
        self._version = 1

    @property
    def name(self) -> str:
        """Role and driver."""
        return self._port.part

    def check(self) -> None:
        """Ask who is there."""
        self._port.reopen_if_lost()
        self._version = int(self._ask("ID?")[1])

    @property
    def has_gamma(self) -> bool:
        """Whether the recorder, when it was last asked who it is, knew a gamma."""
        return self._version >= GAMMA_SINCE

    def set_rate(self, full_frames_per_s: int, pictures_per_frame: int) -> RecordingFormat:
        """Set the rate of the recordings to come; the tape must be stopped or live."""
        match = self._ask("RATE", full_frames_per_s, pictures_per_frame)
        return RecordingFormat(int(match[1]), int(match[2]))

    def live(self) -> None:
        """Show the live image; the tape stops."""
        self._ask("LIVE")

    def record(self) -> int:
        """Start a recording and return its session number; the tape still has to run up."""
        return int(self._ask("RECORD")[1])

    def stop(self) -> None:
        """Stop recording or playback."""
        self._ask("STOP")

    def status(self) -> RecorderStatus:
        """Return mode, session, pictures, time left and place of the tape."""
        match = self._ask("STATUS?")
        return RecorderStatus(
            RecorderMode(match[1]),
            int(match[2]),
            int(match[3]),
            float(match[4]),
            TapePlace(match[5]),
        )

    def mark(self) -> int:
        """Put an event marker on the picture being recorded; return that picture's number."""
        return int(self._ask("MARK")[1])

    def marks(self) -> tuple[int, ...]:
        """Return the pictures of the session that carry a marker."""
        return tuple(int(number) for number in self._ask("MARKS?")[1].split())

    def select_session(self, session: int) -> int:
        """Select a session for playback; return how many pictures it holds."""
        return int(self._ask("SESSION", session)[2])

    def sessions(self) -> dict[int, int]:
        """Return the pictures of each session on the tape."""
        pairs = (pair.split(":") for pair in self._ask("SESSIONS?")[1].split())
        return {int(session): int(pictures) for session, pictures in pairs}

    def replay(self) -> None:
        """Play the latest session from its first picture, at 30 pictures a second."""
        self._ask("REPLAY")

    def play(self) -> None:
        """Play from the present picture, at 30 pictures a second."""
        self._ask("PLAY")

    def step(self, by: int) -> int:
        """Go one picture forward (+1) or back (-1); return where the tape stands."""
        return int(self._ask("STEP", f"{by:+d}")[1])

    def jog(self, pictures_per_s: int) -> None:
        """Show successive pictures, backwards when negative."""
        self._ask("JOG", f"{pictures_per_s:+d}")

    def search(self, picture: int) -> int:
        """Move the tape to a picture of the session; return the one it makes for."""
        return int(self._ask("SEARCH", picture)[1])

    def picture(self) -> int:
        """Return where playback stands."""
        return int(self._ask("PICTURE?")[1])

    def transfer(self, first: int, count: int, name: str) -> None:
        """Have these pictures digitised into the capture folder under a name.

        Raises
        ------
        DeviceAnswerError
            The recorder refused, or took another count or name than it was given.
        """
        match = self._ask("TRANSFER", first, count, name)
        if (int(match[1]), match[2]) != (count, name):
            raise DeviceAnswerError(
                "the recorder transfers something else than it was told",
                part=self.name,
                value=f"{match[1]} pictures as {match[2]}",
                limit=f"{count} pictures as {name}",
                todo="check the recorder's adapter",
            )

    def erase(self) -> None:
        """Rewind the tape; all its sessions are lost."""
        self._ask("ERASE")

    def set_gamma(self, gamma: float) -> None:
        """Set the exponent of the grey levels that it shows and transfers, 0.1 to 1.0."""
        self._ask("GAMMA", f"{gamma:.2f}")

    def gamma(self) -> float:
        """Return that exponent."""
        return float(self._ask("GAMMA?")[1])

    def close(self) -> None:
        """Release the port. Safe to call twice."""
        self._port.close()

    def _ask(self, kind: str, *arguments: object) -> re.Match[str]:
        question = " ".join((kind, *map(str, arguments)))
        own = _ANSWERS[kind]
        answer = self._port.ask(question, late=lambda line: _answers_another(line, own))
        match = own.fullmatch(answer)
        if match is not None:
            return match
        refused = answer.startswith("ERR ")
        raise DeviceAnswerError(
            f"{question!r} was {'refused' if refused else 'answered by something else'}",
            part=self.name,
            value=answer.removeprefix("ERR ") if refused else repr(answer),
            todo="look at the recorder's mode and tape" if refused else "check the adapter",
        )


def _answers_another(line: str, own: re.Pattern[str]) -> bool:
    if own.fullmatch(line):
        return False
    return any(pattern.fullmatch(line) for pattern in _ANSWERS.values())
