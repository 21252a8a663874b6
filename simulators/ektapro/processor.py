"""The processor: obeys keypad, link and remote trigger, one mode at a time."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from dataclasses import dataclass

from simulators.ektapro.modes import PLAYING, TRANSITIONS, Command, Mode
from simulators.ektapro.playback import Playback
from simulators.ektapro.tape import RecordingFormat, Session, Tape

RUN_UP_S = 0.2
REPLAY_PER_S = 30
FASTEST_JOG_PER_S = 30
LEAST_GAMMA, MOST_GAMMA = 0.1, 1.0
# Winding is faster than the highest recording speed (thesis appendix A).
SEARCH_PER_S = 12_000


class RefusedError(Exception):
    """The recorder does not do that now; a refused command changes nothing.

    Parameters
    ----------
    word, detail
        As they follow `ERR` on the link.
    """

    def __init__(self, word: str, detail: str) -> None:
        super().__init__(f"{word} {detail}")


@dataclass(frozen=True, slots=True)
class Status:
    """What `STATUS?` tells: mode, session (0: none), its pictures, tape left in s, tape place."""

    mode: Mode
    session: int
    pictures: int
    left_s: float
    place: str


@dataclass(frozen=True, slots=True)
class Transfer:
    """Pictures to digitise: number n of a session, taken at `first_s + n / pictures_per_s`."""

    name: str
    first: int
    count: int
    first_s: float
    format: RecordingFormat
    gamma: float = 1.0


class Processor:
    """A model of the recorder; in LIVE, with an empty tape, after power-on.

    Parameters
    ----------
    clock
        Laboratory time in seconds.
    run_up_s
        Time from RECORD to the first picture. Kodak gives none; the default is an assumption.

    Notes
    -----
    Nothing here runs by itself: whatever the recorder would have done meanwhile is worked out
    from the clock at the next call. Any thread may call.
    """

    def __init__(self, clock: Callable[[], float], run_up_s: float = RUN_UP_S) -> None:
        self._clock, self._run_up_s = clock, run_up_s
        self._lock = threading.RLock()
        self._tape = Tape()
        self._format = RecordingFormat()
        self._mode = Mode.LIVE
        self._session: Session | None = None
        self._playback = Playback.standing(0)
        self._contact_closed = False
        self._stuck = False
        self._gamma = MOST_GAMMA

    def stick(self, on: bool) -> None:
        """Accept RECORD and never run up; let go again."""
        with self._lock:
            self._stuck = on

    def status(self) -> Status:
        """Return what the recorder does and has."""
        with self._lock:
            now = self._advance()
            room = self._tape.room(self._format, now)
            place = "EOT" if room == 0 else "MID" if self._tape.sessions else "BOT"
            number = self._session.number if self._session else 0
            pictures = self._session.count(now) if self._session else 0
            return Status(self._mode, number, pictures, room / self._format.pictures_per_s, place)

    def sessions(self) -> dict[int, int]:
        """Return the number of pictures of each session on the tape."""
        with self._lock:
            now = self._advance()
            return {session.number: session.count(now) for session in self._tape.sessions}

    def marks(self) -> tuple[int, ...]:
        """Return the marked pictures of the session."""
        with self._lock:
            return tuple(self._session.marks) if self._session else ()

    def picture(self) -> int:
        """Return the picture on which playback stands."""
        with self._lock:
            now = self._advance()
            self._require_pictures(now)
            return self._playback.at(now)

    def contact(self, closed: bool) -> None:
        """Move the remote trigger's contact: a closing edge records, an opening edge stops.

        A closing edge that comes when the recorder cannot record is lost.
        """
        with self._lock:
            edge = closed != self._contact_closed
            self._contact_closed = closed
            if edge and closed:
                with contextlib.suppress(RefusedError):
                    self.record()
            elif edge:
                self.stop()

    def set_rate(self, recording_format: RecordingFormat) -> None:
        """Choose rate and split of the sessions to come."""
        with self._lock:
            self._advance()
            self._enter(Command.RATE)
            self._format = recording_format

    def live(self) -> None:
        """Stop the tape and show the live image."""
        with self._lock:
            now = self._advance()
            self._end_session(now)
            self._enter(Command.LIVE)

    def record(self) -> int:
        """Start the tape for a new session; return the session's number."""
        with self._lock:
            now = self._advance()
            self._allowed(Command.RECORD)
            if self._tape.room(self._format, now) == 0:
                raise RefusedError("EOT", "tape full, ERASE first")
            self._enter(Command.RECORD)
            self._session = self._tape.begin(self._format, now + self._run_up_s)
            return self._session.number

    def stop(self) -> None:
        """Stop recording or playback on the present picture."""
        with self._lock:
            now = self._advance()
            self._end_session(now)
            self._playback = Playback.standing(self._playback.at(now))
            self._enter(Command.STOP)

    def mark(self) -> int:
        """Put an event marker on the picture being recorded; return its number."""
        with self._lock:
            now = self._advance()
            self._enter(Command.MARK)
            session = self._require_session()
            session.marks.append(session.count(now) - 1)
            return session.marks[-1]

    def select(self, number: int) -> int:
        """Select a session and stand on its first picture; return its number of pictures."""
        with self._lock:
            now = self._advance()
            self._allowed(Command.SESSION)
            if not 1 <= number <= len(self._tape.sessions):
                raise RefusedError("RANGE", f"sessions 1 to {len(self._tape.sessions)}")
            self._enter(Command.SESSION)
            self._session = self._tape.sessions[number - 1]
            self._playback = Playback.standing(0)
            return self._session.count(now)

    def replay(self) -> None:
        """Play the latest session from its first picture at 30/s."""
        with self._lock:
            now = self._advance()
            self._allowed(Command.REPLAY)
            latest = self._tape.sessions[-1] if self._tape.sessions else None
            last = _last_picture(latest, now)
            self._enter(Command.REPLAY)
            self._session = latest
            self._playback = Playback(0, last, now, REPLAY_PER_S)

    def play(self) -> None:
        """Play from the present picture at 30/s."""
        with self._lock:
            now = self._advance()
            self._allowed(Command.PLAY)
            self._run(Command.PLAY, REPLAY_PER_S, self._require_pictures(now), now)

    def jog(self, per_s: int) -> None:
        """Show successive pictures, forward or (negative) back, so many a second."""
        with self._lock:
            now = self._advance()
            self._allowed(Command.JOG)
            if not 1 <= abs(per_s) <= FASTEST_JOG_PER_S:
                raise RefusedError("RANGE", f"1 to {FASTEST_JOG_PER_S} pictures a second")
            last = self._require_pictures(now)
            self._run(Command.JOG, abs(per_s), last if per_s > 0 else 0, now)

    def search(self, picture: int) -> int:
        """Wind the tape to a picture; return its number."""
        with self._lock:
            now = self._advance()
            self._allowed(Command.SEARCH)
            self._require_picture(picture, now)
            self._run(Command.SEARCH, SEARCH_PER_S, picture, now)
            return picture

    def step(self, pictures: int) -> int:
        """Move by one picture, +1 or -1; return where playback then stands."""
        with self._lock:
            now = self._advance()
            self._allowed(Command.STEP)
            picture = self._playback.at(now) + pictures
            self._require_picture(picture, now)
            self._enter(Command.STEP)
            self._playback = Playback.standing(picture)
            return picture

    def transfer(self, first: int, count: int, name: str) -> Transfer:
        """Return which recorded pictures of the session are to be digitised."""
        with self._lock:
            now = self._advance()
            self._allowed(Command.TRANSFER)
            session = self._require_session()
            if count < 1 or first + count > session.count(now):
                raise RefusedError("RANGE", f"session holds {session.count(now)} pictures")
            return Transfer(name, first, count, session.first_s, session.format, self._gamma)

    @property
    def gamma(self) -> float:
        """Exponent of the grey levels that are shown and transferred."""
        return self._gamma

    def set_gamma(self, gamma: float) -> None:
        """Choose that exponent (thesis appendix A: 0.1 to 1.0)."""
        if not LEAST_GAMMA <= gamma <= MOST_GAMMA:
            raise RefusedError("RANGE", f"gamma {LEAST_GAMMA} to {MOST_GAMMA}")
        self._gamma = gamma

    def erase(self) -> None:
        """Rewind and lose every session."""
        with self._lock:
            self._advance()
            self._enter(Command.ERASE)
            self._tape.erase()
            self._session = None
            self._playback = Playback.standing(0)

    def _advance(self) -> float:
        """Do what the recorder has done by itself since the last call; return the time."""
        now = self._clock()
        if self._mode is Mode.STARTING:
            self._run_up(now)
        if self._mode is Mode.RECORD and self._session and self._full(self._session, now):
            self._end_session(now)
            self._mode = Mode.STOP
        if self._mode in PLAYING and self._playback.ended(now):
            self._mode = Mode.STOP
        return now

    def _run_up(self, now: float) -> None:
        session = self._require_session()
        if self._stuck:
            session.first_s = now + self._run_up_s
        elif now >= session.first_s:
            self._mode = Mode.RECORD

    @staticmethod
    def _full(session: Session, now: float) -> bool:
        return session.count(now) >= session.room

    def _end_session(self, now: float) -> None:
        if self._mode in (Mode.STARTING, Mode.RECORD):
            session = self._require_session()
            session.pictures = session.count(now)
            self._playback = Playback.standing(max(0, session.pictures - 1))

    def _run(self, command: Command, per_s: float, to: int, now: float) -> None:
        start = self._playback.at(now)
        self._enter(command)
        self._playback = Playback(start, to, now, per_s)

    def _allowed(self, command: Command) -> Mode:
        after = TRANSITIONS[command].get(self._mode)
        if after is None:
            raise RefusedError("MODE", f"{command} not in {self._mode}")
        return after

    def _enter(self, command: Command) -> None:
        self._mode = self._allowed(command)

    def _require_session(self) -> Session:
        if self._session is None:
            raise RefusedError("EMPTY", "no session")
        return self._session

    def _require_pictures(self, now: float) -> int:
        return _last_picture(self._session, now)

    def _require_picture(self, picture: int, now: float) -> None:
        last = self._require_pictures(now)
        if not 0 <= picture <= last:
            raise RefusedError("RANGE", f"pictures 0 to {last}")


def _last_picture(session: Session | None, now: float) -> int:
    if session is None or session.count(now) == 0:
        raise RefusedError("EMPTY", "no pictures")
    return session.count(now) - 1
