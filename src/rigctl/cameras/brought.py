"""A camera that people work, a telephone: they say that it records, and bring its film afterwards.

The rig cannot ask such a camera anything. What replaces its word is a person's, given for this one
shot; what replaces the mark is the film itself, of which the part with the motion is kept.
"""

from __future__ import annotations

import threading
import time
from typing import Literal

from rigctl.cameras.capture import RecordingConfirmation
from rigctl.cameras.checks import Expected, check_frames
from rigctl.cameras.frames import FrameSequence
from rigctl.config import FilmCamera
from rigctl.errors import FramesError, RecordingNotConfirmedError, RefusedError

Wish = Literal["nothing", "recording", "film"]
"""What a shot waits for: that somebody says that the camera records, or brings its film."""
NAME = "camera (film brought by hand)"


class BroughtFilm:
    """A `Capture` whose words and frames come from people. Any thread may call any method.

    Parameters
    ----------
    settings
        Size, rate and window of the frames, and how long people are waited for.
    """

    def __init__(self, settings: FilmCamera) -> None:
        self._settings = settings
        self._changed = threading.Condition()
        self._wish: Wish = "nothing"
        self._said_by = ""
        self._frames: FrameSequence | None = None
        self._given_up = False

    @property
    def name(self) -> str:
        """What the frames come from, as errors and manifests call it."""
        return NAME

    @property
    def settings(self) -> FilmCamera:
        """Its section of the configuration."""
        return self._settings

    @property
    def wish(self) -> Wish:
        """What the shot under way waits for."""
        return self._wish

    def check(self) -> None:
        """Do nothing: only a person sees whether the camera is there."""

    def start(self) -> RecordingConfirmation:
        """Wait until somebody says that the camera records; what was said before does not count.

        Raises
        ------
        RecordingNotConfirmedError
            Nobody did within `start_timeout_s`, or the shot was given up.
        """
        with self._changed:
            self._said_by, self._frames = "", None
            self._await("recording", self._settings.start_timeout_s)
            if not self._said_by:
                raise RecordingNotConfirmedError(
                    "the shot was given up" if self._given_up else "nobody said that it records",
                    part=NAME,
                    limit=f"within {self._settings.start_timeout_s:g} s",
                    todo="fire again, start the film, then say so: the page Film, or `rigctl film "
                    "--records`",
                )
            return RecordingConfirmation(NAME, time.monotonic(), f"{self._said_by} says it records")

    def records(self, who: str) -> None:
        """Take a person's word that the camera records now.

        Raises
        ------
        RefusedError
            No shot waits for it.
        """
        with self._changed:
            self.require("recording")
            self._said_by = who
            self._changed.notify_all()

    def bring(self, frames: FrameSequence) -> None:
        """Take the frames of the shot.

        Raises
        ------
        RefusedError
            No shot waits for them.
        FramesError
            They are not of the configured size and number.
        """
        first = int(frames.sequence[0]) if len(frames.sequence) else 0
        count = len(frames.sequence) + len(frames.lost)
        expected = Expected(first, count, self._settings.rows, self._settings.columns, still=True)
        check_frames(frames, expected)
        with self._changed:
            self.require("film")
            self._frames = frames
            self._changed.notify_all()

    def give_up(self) -> None:
        """End the wait: the camera does not record, or there is no film.

        Raises
        ------
        RefusedError
            No shot waits.
        """
        with self._changed:
            if self._wish == "nothing":
                raise RefusedError("no shot waits for a film", part=NAME, todo="fire a shot first")
            self._given_up = True
            self._changed.notify_all()

    def require(self, wish: Wish) -> None:
        """Raise `RefusedError` unless the shot under way waits for just this."""
        if self._wish != wish:
            raise RefusedError(
                f"no shot waits for {'a film' if wish == 'film' else 'a word'}",
                part=NAME,
                value=f"it waits for {self._wish}",
                limit=f"it waits for {wish}",
                todo="fire a shot, start the camera's film, say so, and bring the film afterwards",
            )

    def mark(self, late_s: float = 0.0) -> None:
        """Do nothing: the film shows by itself where its motion is."""

    def collect(self) -> FrameSequence:
        """Wait for the film.

        Raises
        ------
        FramesError
            None came within `collect_timeout_s`, or the shot was given up.
        """
        with self._changed:
            self._await("film", self._settings.collect_timeout_s)
            if self._frames is None:
                raise FramesError(
                    "there is no film: the shot was given up" if self._given_up else "no film came",
                    part=NAME,
                    limit=f"{self._settings.collect_timeout_s:g} s",
                    todo="bring it sooner, or allow a longer camera.collect_timeout_s",
                )
            return self._frames

    def stop(self) -> None:
        """Wait no more; harmless when nothing does."""
        with self._changed:
            self._wish = "nothing"

    def close(self) -> None:
        """End a wait, as the rig closes. Safe to call twice."""
        with self._changed:
            self._given_up = True
            self._changed.notify_all()

    def _await(self, wish: Wish, longest_s: float) -> None:
        """Wait for what is wished, or until the shot is given up; the lock is held."""
        self._wish, self._given_up = wish, False
        self._changed.wait_for(lambda: self._given_up or self._has(wish), longest_s)
        self._wish = "nothing"

    def _has(self, wish: Wish) -> bool:
        return bool(self._said_by) if wish == "recording" else self._frames is not None
