"""What the rig asks of its devices, by role; brands live in the modules beside this one.

Every method returns within the bound that its driver was configured with or raises one of
`rigctl.errors`. Queries may be repeated by a driver; `Trigger.fire` never is.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Protocol, runtime_checkable


@dataclass(frozen=True, slots=True)
class Reading:
    """A measured quantity with its unit and the monotonic time at which it was read (s)."""

    value: float
    unit: str
    read_at: float


class Device(Protocol):
    """Anything with a name that can be made safe and closed."""

    @property
    def name(self) -> str:
        """Role and driver, as errors and the state report call it."""

    def check(self) -> None:
        """Ask the device for a sign of life; raise a `DeviceError` if there is none."""

    def close(self) -> None:
        """Release the port. Safe to call twice."""


class Actuator(Device, Protocol):
    """What can move something. Its `check` never opens a line that was lost; `reopen` does.

    A command that acts must not go out on a line that came back unnoticed. Lines come back when
    the rig is armed or released, and on the way to a safe level: never between arm and fire.
    """

    def reopen(self) -> None:
        """See whether the line is there, and open it again if it was lost.

        Raises
        ------
        DeviceError
            It cannot be opened.
        """


@dataclass(frozen=True, slots=True)
class FireReceipt:
    """The trigger's own word that it fired.

    `sent_at` and `confirmed_at` are monotonic seconds of the host; `device_time_us` is the
    device's own clock at the first pulse, where it has one.
    """

    sequence: int
    sent_at: float
    confirmed_at: float
    device_time_us: int | None


class Trigger(Actuator, Protocol):
    """Fires both pushers (or solenoids) from one command."""

    def arm(self, sequence: int, delay_us: float) -> None:
        """Make ready to fire once, under this sequence number, with b `delay_us` after a."""

    def fire(self, sequence: int) -> FireReceipt:
        """Send the fire command once.

        Raises
        ------
        DeviceAnswerError
            The device refused: it did not fire.
        FireOutcomeUnknownError
            The command left, and no clear answer came back.
        """

    def make_safe(self) -> None:
        """Drive every line to its safe level; harmless in any state."""


class FireOutcome(Enum):
    """What became of a fire command whose answer did not come."""

    FIRED = "fired"
    NOT_FIRED = "not fired"
    UNKNOWN = "unknown"


@runtime_checkable
class OutcomeQuery(Protocol):
    """A trigger that can say afterwards whether it fired; not every one can."""

    def outcome(self, sequence: int) -> FireOutcome:
        """Ask what became of this fire command; a query, it fires nothing and never raises."""


@runtime_checkable
class PowerQuery(Protocol):
    """A trigger that can say whether its outputs have power; not every one can."""

    def powered(self) -> bool:
        """Say whether a fire command could move anything; raise a `DeviceError` if unheard."""


@runtime_checkable
class FirmwareQuery(Protocol):
    """A device that says which firmware it runs; not every one can."""

    def firmware(self) -> str:
        """Return its own words, with the version; raise a `DeviceError` if unheard."""


@runtime_checkable
class HeartbeatWatch(Protocol):
    """A trigger that can watch over its host, and make itself safe when the host dies or hangs."""

    def watch(self, within_s: float) -> bool:
        """Begin to watch, with this longest silence; False where this device cannot."""

    def beat(self) -> bool:
        """Tell it that the host lives; False where it does not watch any more."""

    def end_watch(self) -> None:
        """Have it watch no more: it stays safe."""


class Regulator(Actuator, Protocol):
    """Sets and reads the pressure of both pushers."""

    def set_pressure(self, a_kpa: float, b_kpa: float) -> None:
        """Give both set points in kPa gauge; returns before the pressure has settled."""

    def vent(self) -> None:
        """Give both set points of 0 kPa; the second is given even when the first is not taken."""

    def pressure(self) -> tuple[Reading, Reading]:
        """Return the measured pressures of a and b in kPa gauge."""


class Slide(Actuator, Protocol):
    """Moves tube b vertically against tube a."""

    def move_to(self, offset_mm: float) -> None:
        """Start a move; returns before it has ended."""

    def stop(self) -> None:
        """End a move where it is; harmless at rest."""

    def position(self) -> Reading:
        """Return the measured offset in mm."""

    def is_moving(self) -> bool:
        """Say whether a move is under way."""


class Closure(Device, Protocol):
    """A contact that closes: the camera's remote trigger."""

    def close_contact(self) -> None:
        """Close the contact and hold it."""

    def open_contact(self) -> None:
        """Open the contact."""


class CutOff(Actuator, Protocol):
    """Cuts the power of every actuator, on a line of its own."""

    def cut(self) -> None:
        """Cut at once, on a line opened again if it was lost; harmless when already cut."""

    def restore(self) -> None:
        """Give power back, after a person released the latch; opens no line."""


class Tubes(Protocol):
    """Rotatable tubes that follow what a shot states; real ones are turned by hand."""

    def turn_tubes(self, a_deg: float, b_deg: float, /) -> None:
        """Turn tube a and tube b to their tilts below the horizontal, degrees."""


@dataclass(frozen=True, slots=True)
class Actuators:
    """The opened devices of one rig; the release apparatus has neither regulator nor slide.

    `tubes` are None but on its simulated kind.
    """

    trigger: Trigger
    regulator: Regulator | None
    slide: Slide | None
    cut_off: CutOff
    tubes: Tubes | None = None
