"""The rig as a device: `set` arms for a step, `trigger` fires it once, `read` gives the results."""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Callable, Mapping
from datetime import datetime
from typing import Any

from bluesky.protocols import Hints, Movable, Readable, Reading, Stageable, Status, Triggerable
from event_model import DataKey

from rigctl.bluesky_devices.step import Progress, Step
from rigctl.errors import FireOutcomeUnknownError, RefusedError
from rigctl.firing import Operable, measured
from rigctl.units import RATIO

SETTINGS = {"pressure_a_kpa": "kPa", "pressure_b_kpa": "kPa", "offset_mm": "mm", "delay_us": "us"}
QUANTITIES = {
    **dict.fromkeys(("v_n", "v_s", "v_n_after", "v_s_after"), "m/s"),
    **dict.fromkeys(("e", "beta"), RATIO),
    "contact_duration": "s",
}
WORDS = ("shot", "state")


def described(name: str) -> dict[str, DataKey]:
    """Return the data keys of a device of this name."""
    numbers = {**SETTINGS}
    for quantity, unit in QUANTITIES.items():
        numbers |= {quantity: unit, f"{quantity}_sigma": unit}
    keys = {
        f"{name}_{key}": DataKey(source="rigctl", dtype="number", shape=[], units=unit)
        for key, unit in numbers.items()
    }
    for word in WORDS:
        keys[f"{name}_{word}"] = DataKey(source="rigctl", dtype="string", shape=[])
    return keys


def read_of(name: str, shot: Mapping[str, Any]) -> dict[str, Reading[Any]]:
    """Return the readings of a shot, as `rigctl.firing.measured` gives it.

    What was not measured is NaN. All carry the time at which the shot was fired.
    """
    settings, result = shot["settings"], shot["result"] or {}
    values: dict[str, Any] = {key: _number(settings.get(key)) for key in SETTINGS}
    for quantity in QUANTITIES:
        found = result.get(quantity) or {}
        values[quantity] = _number(found.get("value"))
        values[f"{quantity}_sigma"] = _number(found.get("sigma"))
    values |= {word: str(shot[word]) for word in WORDS}
    fired = datetime.fromisoformat(shot["fired_at"] or shot["accepted_at"]).timestamp()
    return {f"{name}_{key}": Reading(value=v, timestamp=fired) for key, v in values.items()}


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)


_log = logging.getLogger(__name__)


class WorkStatus(Status):
    """Done when the work has ended, successful when it raised nothing.

    Parameters
    ----------
    name
        Of the work, for those who look at a status that lasts.
    work
        Bounds its own waits; it is not interrupted.
    """

    def __init__(self, name: str, work: Callable[[], None]) -> None:
        self.name = name
        self._work = work
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._failure: BaseException | None = None
        self._callbacks: list[Callable[[Status], None]] = []
        threading.Thread(target=self._run, name=name, daemon=True).start()

    def __repr__(self) -> str:
        state = "running" if not self.done else "done" if self.success else repr(self._failure)
        return f"<{self.name}: {state}>"

    def add_callback(self, callback: Callable[[Status], None]) -> None:
        """Call this when the work has ended; at once, if it has."""
        with self._lock:
            if not self._ended.is_set():
                self._callbacks.append(callback)
                return
        callback(self)

    def exception(self, timeout: float | None = 0.0) -> BaseException | None:
        """Return what the work raised, waiting at most `timeout` seconds for its end.

        Raises
        ------
        TimeoutError
            It has not ended.
        """
        if not self._ended.wait(timeout):
            raise TimeoutError(f"{self.name} has not ended")
        return self._failure

    @property
    def done(self) -> bool:
        """Whether the work has ended."""
        return self._ended.is_set()

    @property
    def success(self) -> bool:
        """Whether it has ended well."""
        return self.done and self._failure is None

    def _run(self) -> None:
        try:
            self._work()
        except Exception as error:  # noqa: BLE001 - raised to the waiting caller
            self._failure = error
        with self._lock:
            self._ended.set()
            callbacks, self._callbacks = self._callbacks, []
        for callback in callbacks:
            try:
                callback(self)
            except Exception:  # noqa: BLE001 - whatever the others' callbacks raise
                # Such as that of an engine which was closed meanwhile; the others are called.
                _log.exception("%s has ended, and a callback of it failed", self.name)


WAIT_S = 120.0
"""Longest wait for the measurement of a shot."""


class Rig(Readable[Any], Movable[Step], Triggerable, Stageable):
    """The rig behind a daemon.

    A step that has been fired is never fired again, however often a run engine hands it over: not
    when it rewinds, and not when the daemon's answer was lost. It cannot be stopped by the run
    engine; the emergency stop is the daemon's own. A rig that was armed and is not fired disarms
    itself when its token expires.

    Parameters
    ----------
    client
        A daemon (`rigctl.client.connected`), or a rig in this process.
    name
        Prefix of the name of every reading.
    campaign
        That the shots belong to.
    wait_s
        Longest wait for the measurement of a shot, s.
    clock, pause
        For that wait.
    """

    parent = None

    def __init__(
        self,
        client: Operable,
        *,
        name: str = "rig",
        campaign: str | None = None,
        wait_s: float = WAIT_S,
        clock: Callable[[], float] = time.monotonic,
        pause: Callable[[float], None] = time.sleep,
    ) -> None:
        self._client, self._name, self._campaign = client, name, campaign
        self._wait_s, self._clock, self._pause = wait_s, clock, pause
        # One act at a time; what is under way in a thread is not overtaken.
        self._lock = threading.Lock()
        self._progress: dict[str, Progress] = {}
        self._step: Step | None = None
        self._last: Mapping[str, Any] | None = None

    @property
    def name(self) -> str:
        """The device's name."""
        return self._name

    @property
    def hints(self) -> Hints:
        """What is worth looking at."""
        return {"fields": [f"{self._name}_e"]}

    def stage(self) -> list[Any]:
        """Forget the last reading; the rig itself is armed for each step."""
        self._last = None
        return [self]

    def unstage(self) -> list[Any]:
        """Do nothing: a rig that is not fired disarms itself."""
        return [self]

    def set(self, value: Step) -> Status:
        """Arm the rig for a step; one that was fired already is left alone."""
        return WorkStatus(f"arm {self._name}", lambda: self._arm(value))

    def trigger(self) -> Status:
        """Fire the step that was set, once, and wait for its measurement."""
        return WorkStatus(f"fire {self._name}", self._fire)

    def read(self) -> dict[str, Reading[Any]]:
        """Return the shot that was fired last.

        Raises
        ------
        RefusedError
            Nothing was fired.
        """
        if self._last is None:
            raise RefusedError("nothing was fired", part=self._name, todo="trigger it first")
        return read_of(self._name, self._last)

    def describe(self) -> dict[str, DataKey]:
        """Return the data keys of `read`."""
        return described(self._name)

    def _arm(self, step: Step) -> None:
        with self._lock:
            progress = self._progress.setdefault(step.key, Progress())
            self._step = step
            if not progress.sent:
                progress.token = self._client.arm(step.settings).token

    def _fire(self) -> None:
        with self._lock:
            shot = self._fired_once()
            self._last = measured(
                self._client, shot, self._wait_s, clock=self._clock, pause=self._pause
            )

    def _fired_once(self) -> str:
        """Return the shot of the step that was set, and fire it if that was never tried."""
        if self._step is None:
            raise RefusedError("no step was set", part=self._name, todo="set it first")
        progress = self._progress[self._step.key]
        if progress.shot is not None:
            return progress.shot
        if progress.sent:
            raise FireOutcomeUnknownError(
                "the fire command was sent and its answer lost; it is not sent again",
                part=self._name,
                todo="look at the daemon's list of shots",
            )
        if progress.token is None:
            raise RefusedError("is not armed", part=self._name, todo="set it to a fresh step")
        progress.sent = True
        progress.shot = self._client.fire(progress.token, self._step.key, self._campaign)
        return progress.shot
