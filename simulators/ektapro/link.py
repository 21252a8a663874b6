"""The recorder's link: lines of text in, lines of text out.

This is the project's own protocol (`docs/reference/wire-protocols.md`), not Kodak's.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from simulators.ektapro.processor import Processor, RefusedError, Transfer
from simulators.ektapro.tape import RecordingFormat

_NUMBER = r"(\d{1,9})"
_SIGNED = r"([+-]\d{1,9})"


class Link:
    """Speaks for a processor.

    Parameters
    ----------
    processor
        The recorder.
    digitise
        Takes a transfer to carry out while the link goes on answering; it raises `ValueError`
        when it cannot take that name.
    """

    def __init__(self, processor: Processor, digitise: Callable[[Transfer], None]) -> None:
        self._processor, self._digitise = processor, digitise
        self._commands: list[tuple[re.Pattern[str], Callable[..., str]]] = [
            (re.compile(pattern, re.ASCII), handler)
            for pattern, handler in (
                (r"ID\?", lambda: "EKTAPRO-SIM 2"),
                (rf"RATE {_NUMBER} {_NUMBER}", self._rate),
                (r"LIVE", self._live),
                (r"RECORD", lambda: f"RECORD {processor.record()}"),
                (r"STOP", self._stop),
                (r"STATUS\?", self._status),
                (r"MARK", lambda: f"MARK {processor.mark()}"),
                (r"MARKS\?", lambda: " ".join(map(str, processor.marks()))),
                (rf"SESSION {_NUMBER}", self._session),
                (r"SESSIONS\?", self._sessions),
                (r"REPLAY", self._replay),
                (r"PLAY", self._play),
                (r"STEP ([+-]1)", lambda by: f"PICTURE {processor.step(int(by))}"),
                (rf"JOG {_SIGNED}", self._jog),
                (rf"SEARCH {_NUMBER}", lambda to: f"PICTURE {processor.search(int(to))}"),
                (r"PICTURE\?", lambda: f"PICTURE {processor.picture()}"),
                (rf"TRANSFER {_NUMBER} {_NUMBER} ([A-Za-z0-9_-]{{1,64}})", self._transfer),
                (r"ERASE", self._erase),
                (r"GAMMA ([01]\.\d\d)", self._gamma),
                (r"GAMMA\?", lambda: f"GAMMA {processor.gamma:.2f}"),
            )
        ]

    def answer(self, line: bytes) -> bytes:
        """Answer one line (without its ending)."""
        text = line.decode("ascii", errors="replace")
        for pattern, handler in self._commands:
            if found := pattern.fullmatch(text):
                try:
                    return f"OK {handler(*found.groups())}".rstrip().encode() + b"\n"
                except RefusedError as refusal:
                    return f"ERR {refusal}\n".encode()
        return b"ERR SYNTAX unknown command\n"

    def _rate(self, full_frames: str, split: str) -> str:
        try:
            recording_format = RecordingFormat(int(full_frames), int(split))
        except ValueError as error:
            raise RefusedError("RANGE", str(error)) from error
        self._processor.set_rate(recording_format)
        return f"{recording_format.pictures_per_s} {recording_format.rows}"

    def _live(self) -> str:
        self._processor.live()
        return "LIVE"

    def _stop(self) -> str:
        self._processor.stop()
        return "STOP"

    def _status(self) -> str:
        status = self._processor.status()
        return (
            f"{status.mode} {status.session} {status.pictures} {status.left_s:.3f} {status.place}"
        )

    def _session(self, number: str) -> str:
        return f"SESSION {int(number)} {self._processor.select(int(number))}"

    def _sessions(self) -> str:
        return " ".join(f"{k}:{pictures}" for k, pictures in self._processor.sessions().items())

    def _replay(self) -> str:
        self._processor.replay()
        return "REPLAY"

    def _play(self) -> str:
        self._processor.play()
        return "PLAY"

    def _jog(self, per_s: str) -> str:
        self._processor.jog(int(per_s))
        return "JOG"

    def _transfer(self, first: str, count: str, name: str) -> str:
        transfer = self._processor.transfer(int(first), int(count), name)
        try:
            self._digitise(transfer)
        except ValueError as error:
            raise RefusedError("NAME", str(error)) from error
        return f"TRANSFER {transfer.count} {name}"

    def _gamma(self, exponent: str) -> str:
        self._processor.set_gamma(float(exponent))
        return f"GAMMA {exponent}"

    def _erase(self) -> str:
        self._processor.erase()
        return "BOT"
