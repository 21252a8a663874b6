"""The recorder's modes and which command leads from which to which."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum


class Mode(StrEnum):
    """What the recorder does at present."""

    LIVE = "LIVE"
    STARTING = "STARTING"
    RECORD = "RECORD"
    STOP = "STOP"
    REPLAY = "REPLAY"
    PLAY = "PLAY"
    JOG = "JOG"
    SEARCH = "SEARCH"


class Command(StrEnum):
    """What it can be told in words of the keypad; queries are allowed in every mode."""

    RATE = "RATE"
    LIVE = "LIVE"
    RECORD = "RECORD"
    STOP = "STOP"
    MARK = "MARK"
    SESSION = "SESSION"
    REPLAY = "REPLAY"
    PLAY = "PLAY"
    STEP = "STEP"
    JOG = "JOG"
    SEARCH = "SEARCH"
    TRANSFER = "TRANSFER"
    ERASE = "ERASE"


PLAYING = (Mode.REPLAY, Mode.PLAY, Mode.JOG, Mode.SEARCH)
_RESTING = (Mode.LIVE, Mode.STOP)
_STAY = {mode: mode for mode in _RESTING}

TRANSITIONS: Mapping[Command, Mapping[Mode, Mode]] = {
    Command.RATE: _STAY,
    Command.LIVE: dict.fromkeys(Mode, Mode.LIVE),
    Command.RECORD: dict.fromkeys((*_RESTING, *PLAYING), Mode.STARTING),
    Command.STOP: dict.fromkeys(Mode, Mode.STOP),
    Command.MARK: {Mode.RECORD: Mode.RECORD},
    Command.SESSION: dict.fromkeys((*_RESTING, *PLAYING), Mode.STOP),
    Command.REPLAY: dict.fromkeys((*_RESTING, *PLAYING), Mode.REPLAY),
    Command.PLAY: dict.fromkeys((*_RESTING, *PLAYING), Mode.PLAY),
    Command.STEP: dict.fromkeys((*_RESTING, *PLAYING), Mode.STOP),
    Command.JOG: dict.fromkeys((*_RESTING, *PLAYING), Mode.JOG),
    Command.SEARCH: dict.fromkeys((*_RESTING, *PLAYING), Mode.SEARCH),
    Command.TRANSFER: _STAY,
    Command.ERASE: dict.fromkeys(_RESTING, Mode.STOP),
}
"""A command is refused in every mode that its row does not name.

By themselves: STARTING becomes RECORD when the tape has run up, RECORD becomes STOP at the end of
the tape, and each kind of playback becomes STOP at its last picture.
"""
