"""The laboratory: every simulated device on its port, wired to one another and to the world."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from simulators.chosen_world import Filmed, world_of
from simulators.chronos.camera import Camera, CameraFault
from simulators.chronos.server import CameraServer
from simulators.ektapro.digitiser import Digitiser
from simulators.ektapro.faults import FrameFault, FrameFaults
from simulators.ektapro.link import Link
from simulators.ektapro.processor import Processor
from simulators.holders import Holders
from simulators.options import Options, read_options
from simulators.wire import protocol_sim
from simulators.wire.alicat import PressureRegulator
from simulators.wire.faults import SerialDevice, SerialFaults
from simulators.wire.framing import Framing, Lines
from simulators.wire.hid_relay import HidRelay, HidRelayBackend
from simulators.wire.lcus import LcusFrames, LcusRelay
from simulators.wire.pty_port import PtyPort
from simulators.wire.trigger_box import Pulses, TriggerBox
from simulators.wire.zaber import ZaberStage
from simulators.world import Launch
from simulators.world.description import Magnet
from simulators.world.release import Release

RELAY_CHANNELS = 2
CUT_OFF_CHANNEL = 1
REMOTE_TRIGGER_CHANNEL = 1
REMOTE_TRIGGER = "remote-trigger"
CHRONOS = "chronos"
ROLES = (
    "trigger",
    "solenoids",
    "regulator",
    "slide",
    "cut-off",
    "recorder",
    "capture",
    REMOTE_TRIGGER,
)
STUCK, UNPLUG, PLUG_IN, NEVER_STARTS = "stuck", "unplug", "plug-in", "never-starts"
OTHER_FIRMWARE = "other-firmware"
FIRMWARE, UNKNOWN_FIRMWARE = 2, 3


@dataclass(frozen=True, slots=True)
class _SerialDevice:
    """What a fault needs of a device on a port."""

    port: PtyPort
    faults: SerialFaults
    stick: Callable[[bool], None]


class Laboratory:
    """Six devices on ports, a relay on USB, and the world that they act on.

    Parameters
    ----------
    folder
        Gets the ports' names, `capture` and `truth`.
    options
        See `Options`.
    world
        What the outputs fire and the recorder sees; None: that of the options.
    clock
        Laboratory time in seconds, shared by every device and the world.

    Notes
    -----
    Power-on state: actuators without power (the cut-off relay is off), regulators at 0 kPa, the
    slide without reference, an empty tape. Any thread may call.
    """

    def __init__(
        self, folder: Path, options: Options, world: Filmed | None, clock: Callable[[], float]
    ) -> None:
        self._stage = ZaberStage(clock, options.slide_speed_mm_per_s)
        if world is None:
            world = world_of(options, folder / "truth", self._stage.position_mm)
        self._folder, self._world, self._clock = folder, world, clock
        self._watch_contact = options.watch_contact
        self._regulator = PressureRegulator(clock, lag_s=options.pressure_lag_s)
        self._box = TriggerBox(clock, self._fire, contact_in_power=options.watch_contact)
        self._cut_off = LcusRelay(RELAY_CHANNELS, self._switch_power)
        self._holders = _holders(options, clock, self._let_go)
        self._solenoids = LcusRelay(RELAY_CHANNELS, self._holders.switch)
        self._recorder = Processor(clock, options.run_up_s)
        self._angles_deg: tuple[float, float] | None = None
        self._power_switched_s: float | None = None
        self._switch_closed = True
        self._chronos = Camera(clock, world.picture)
        self._chronos_server: CameraServer | None = None
        self._frame_faults = FrameFaults()
        self._digitiser = Digitiser(folder / "capture", world.picture, self._frame_faults)
        link = Link(self._recorder, self._digitiser.start)
        self._relay = HidRelay(RELAY_CHANNELS, self._switch_contact)
        self._usb = HidRelayBackend(self._relay)
        remote = f"{folder.absolute()}/{REMOTE_TRIGGER}"
        self._remote_url = protocol_sim.publish(remote, self._recorder.contact)
        self._devices: dict[str, _SerialDevice] = {}
        self._connect("trigger", Lines(b"\n"), self._box.answer, self._box.stick)
        self._connect("solenoids", LcusFrames(), self._solenoids.answer, self._solenoids.stick)
        self._connect("regulator", Lines(b"\r"), self._regulator.answer, self._regulator.stick)
        self._connect("slide", Lines(b"\n"), self._stage.answer, self._stage.stick)
        self._connect("cut-off", LcusFrames(), self._cut_off.answer, self._cut_off.stick)
        self._connect("recorder", Lines(b"\n"), link.answer, self._recorder.stick)

    @property
    def fires(self) -> int:
        """How many fires reached the world: the oracle of every at-most-once test."""
        return self._world.fires

    @property
    def truth_folder(self) -> Path:
        """Where the world writes what really happened; the daemon never reads it."""
        return self._folder / "truth"

    def port(self, role: str) -> str:
        """Return what a host opens for a role: a device's path, or the capture folder.

        `chronos` is the address of a camera's HTTP service, which begins with the first call.
        `remote-trigger` is a URL for pyserial, valid in this process: a port whose RTS line is
        the recorder's contact, as an alternative to the relay.

        Raises
        ------
        ValueError
            The laboratory has no such role.
        """
        if role == "capture":
            return str(self._folder / "capture")
        if role == REMOTE_TRIGGER:
            return self._remote_url
        if role == CHRONOS:
            # Nobody listens on a network port unless a configuration has this camera.
            self._chronos_server = self._chronos_server or CameraServer(self._chronos)
            return self._chronos_server.url
        if role not in self._devices:
            raise ValueError(f"the simulated laboratory has no {role!r}; it has {', '.join(ROLES)}")
        return self._devices[role].port.path

    def usb_backend(self) -> HidRelayBackend:
        """Return the bus with the relay, whose channel 1 is the recorder's remote trigger."""
        return self._usb

    def fault(
        self,
        device: str,
        kind: str,
        *,
        times: int | None = None,
        delay_s: float = 0.2,
        command: str = "",
        frames: int = 1,
    ) -> None:
        """Make a device misbehave from now on.

        Parameters
        ----------
        device
            `trigger`, `solenoids`, `regulator`, `slide`, `cut-off`, `recorder`, `relay` or
            `chronos`.
        kind
            Of every device but the recorder: `stuck`. Of those on a port: a `SerialFault`,
            `unplug`, `plug-in`. Of the trigger: `other-firmware`, a version that nobody knows. Of
            the recorder: a `FrameFault` or `never-starts`. Of the relay:
            a `UsbFault`. Of `chronos`: a `CameraFault`, or `unplug`, which ends its service.
        times
            How many commands or transfers it strikes; None: until `clear_faults`.
        delay_s, command
            See `SerialFaults.set`.
        frames
            See `FrameFaults.set`.

        Raises
        ------
        ValueError
            No such device, kind, or number.
        """
        if device == CHRONOS:
            self._fault_chronos(kind)
        elif device == "relay":
            self._fault_relay(kind, times)
        elif device not in self._devices:
            names = ", ".join([*self._devices, "relay", CHRONOS])
            raise ValueError(f"no device {device!r}; there are {names}")
        elif device == "recorder" and kind in set(FrameFault):
            self._frame_faults.set(kind, times=times, frames=frames)
        elif device == "trigger" and kind == OTHER_FIRMWARE:
            self._box.flash(UNKNOWN_FIRMWARE)
        elif kind == UNPLUG:
            self._devices[device].port.unplug()
        elif kind == PLUG_IN:
            self._devices[device].port.plug_in()
        elif kind == (NEVER_STARTS if device == "recorder" else STUCK):
            self._devices[device].stick(True)
        else:
            faults = self._devices[device].faults
            faults.set(kind, times=times, delay_s=delay_s, command=command)

    def clear_faults(self) -> None:
        """Remove every fault, let go whatever is stuck and plug in whatever is unplugged."""
        for device in self._devices.values():
            device.faults.clear()
            device.stick(False)
            device.port.plug_in()
        self._frame_faults.clear()
        self._box.flash(FIRMWARE)
        self._chronos.fault = None
        self._relay.stick(False)
        self._usb.clear()

    def move_contact(self, closed: bool) -> None:
        """Close or open the recorder's remote trigger by hand, without the relay."""
        self._recorder.contact(closed)

    def move_switch(self, closed: bool) -> None:
        """Close or open the switch that a hand reaches, in series with the cut-off."""
        self._switch_closed = closed
        self._power(self._cut_off.is_on(CUT_OFF_CHANNEL))

    def turn_tubes(self, a_deg: float, b_deg: float) -> None:
        """Turn the tubes by hand, as somebody does before a shot; without tubes nothing turns."""
        self._angles_deg = a_deg, b_deg

    def state(self) -> dict[str, object]:
        """Return how things stand in the laboratory, for people and tests.

        `power_switched_s` is the laboratory's time at which relay or watch contact last switched,
        `watch_late_s` that at which the trigger box missed its heartbeat.
        """
        now = self._clock()
        return {
            "fires": self.fires,
            "pressure_a_kpa": self._regulator.pressure_kpa("A", now),
            "pressure_b_kpa": self._regulator.pressure_kpa("B", now),
            "offset_mm": self._stage.position_mm(now),
            "powered": self._box.is_powered,
            "power_switched_s": self._power_last_switched_s(),
            "armed": self._box.is_armed,
            "watch_late_s": self._box.late_since_s,
            "recorder": str(self._recorder.status().mode),
        }

    def close(self) -> None:
        """Unplug everything and stop every thread. Safe to call twice."""
        for device in self._devices.values():
            device.port.close()
        self._holders.close()
        if self._chronos_server is not None:
            self._chronos_server.close()
        protocol_sim.withdraw(self._remote_url)
        self._digitiser.close()

    def _connect(
        self,
        role: str,
        framing: Framing,
        answer: Callable[[bytes], bytes],
        stick: Callable[[bool], None],
    ) -> None:
        faults = SerialFaults()
        port = PtyPort(SerialDevice(framing, answer, faults).receive, self._folder / role)
        self._devices[role] = _SerialDevice(port, faults, stick)

    def _fault_chronos(self, kind: str) -> None:
        if kind == UNPLUG:
            if self._chronos_server is not None:
                self._chronos_server.close()
        else:
            self._chronos.fault = CameraFault(kind)

    def _fault_relay(self, kind: str, times: int | None) -> None:
        if kind == STUCK:
            self._relay.stick(True)
        else:
            self._usb.fault(kind, times=times)

    def _fire(self, pulses: Pulses) -> None:
        self._world.fire(
            Launch(
                pressure_a_kpa=self._regulator.pressure_kpa("A", pulses.a_s),
                pressure_b_kpa=self._regulator.pressure_kpa("B", pulses.b_s),
                offset_m=self._stage.position_mm(pulses.a_s) * 1e-3,
                fire_a_s=pulses.a_s,
                fire_b_s=pulses.b_s,
            )
        )

    def _let_go(self, release: Release) -> None:
        self._world.fire(replace(release, angles_deg=self._angles_deg))

    def _switch_power(self, channel: int, on: bool) -> None:
        if channel == CUT_OFF_CHANNEL:
            self._power_switched_s = self._clock()
            self._power(on)

    def _power(self, cut_off_closed: bool) -> None:
        """Give power where both the cut-off and the switch at hand are closed."""
        powered = cut_off_closed and self._switch_closed
        self._box.power(powered)
        self._holders.power(powered)

    def _power_last_switched_s(self) -> float | None:
        late_s = self._box.late_since_s if self._watch_contact else None
        if late_s is None or self._power_switched_s is None:
            return self._power_switched_s
        # Relay and contact lie in one line: the first of them that opened took the power.
        off = not self._cut_off.is_on(CUT_OFF_CHANNEL)
        return min(late_s, self._power_switched_s) if off else late_s

    def _switch_contact(self, channel: int, closed: bool) -> None:
        if channel == REMOTE_TRIGGER_CHANNEL:
            self._recorder.contact(closed)


def open_laboratory(folder: Path, options: Mapping[str, object]) -> Laboratory:
    """Build the laboratory in a folder; the factory that a configuration names.

    `options` are those of `[simulation]`, and under `scene` what the configuration says of spheres,
    surroundings and optics: the simulated world has just these.

    Raises
    ------
    ValueError
        An option is unknown or outside its limits.
    """
    checked = read_options(options)
    folder.mkdir(parents=True, exist_ok=True)
    return Laboratory(folder, checked, None, time.monotonic)


def _holders(
    options: Options, clock: Callable[[], float], let_go: Callable[[Release], object]
) -> Holders:
    """Return what the board's channels hold: a sphere each, or one on a magnet; pushers nothing."""
    holder = options.world.holder
    channels = () if holder is None else (1,) if isinstance(holder, Magnet) else (1, 2)
    return Holders(
        channels,
        holds_energised=options.holds_energised,
        clock=clock,
        release=let_go,
    )
