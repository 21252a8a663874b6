"""From the sections of the configuration to opened devices."""

from __future__ import annotations

from contextlib import ExitStack
from typing import Protocol

import usb.backend

from rigctl.config import SIMULATED, Configuration, Lcus, Magnet, SolenoidPair, TriggerSection
from rigctl.config import Alicat as AlicatSection
from rigctl.config import Zaber as ZaberSection
from rigctl.devices import alicat, lcus
from rigctl.devices.alicat import AlicatPair
from rigctl.devices.lcus import LcusRelay
from rigctl.devices.roles import Actuators, Trigger
from rigctl.devices.serial_port import SerialPort
from rigctl.devices.trigger_box import TriggerBox
from rigctl.devices.zaber import ZaberSlide
from rigctl.errors import ConfigurationError

TRIGGER_BOX_BAUD = 115200
WRITE_TIMEOUT_S = 0.5
"""Longest wait for boards that never answer to take their bytes."""


class Laboratory(Protocol):
    """What stands in for the real ports on a simulated rig."""

    def port(self, role: str, /) -> str:
        """Return the device path or folder of a simulated role; raise `ValueError` at no role."""

    def usb_backend(self) -> usb.backend.IBackend:
        """Return the simulated bus."""

    def turn_tubes(self, a_deg: float, b_deg: float, /) -> None:
        """Turn the simulated tubes of the release apparatus, as hands do on a real one."""


def build_actuators(configuration: Configuration, laboratory: Laboratory | None) -> Actuators:
    """Open every actuator of a configuration; none stays open when one fails.

    Nothing is switched and nothing moves.

    Raises
    ------
    DeviceError
        A port is absent, busy or forbidden.
    ConfigurationError
        A port is simulated and there is no simulated laboratory.
    """
    with ExitStack() as opened:
        cut_off = _cut_off(configuration.cut_off, laboratory)
        opened.callback(cut_off.close)
        trigger = build_trigger(configuration.trigger, laboratory)
        opened.callback(trigger.close)
        regulator = None
        if configuration.regulator is not None:
            regulator = _regulator(configuration.regulator, laboratory)
            opened.callback(regulator.close)
        slide = None
        if configuration.slide is not None:
            slide = build_slide(configuration.slide, laboratory)
        opened.pop_all()
    turned = laboratory if configuration.apparatus == "release" else None
    return Actuators(trigger, regulator, slide, cut_off, turned)


def resolved(port: str, laboratory: Laboratory | None) -> str:
    """Return the device path, URL or folder behind a port of the configuration.

    Raises
    ------
    ConfigurationError
        The port is simulated, and there is no simulated laboratory or it has no such role.
    """
    if not port.startswith(SIMULATED):
        return port
    if laboratory is None:
        raise ConfigurationError(
            "the port is simulated, and there is no simulated laboratory",
            part=port,
            todo="name a real port, or add the table [simulation]",
        )
    try:
        return laboratory.port(port.removeprefix(SIMULATED))
    except ValueError as error:
        raise ConfigurationError(
            str(error), part=port, todo="correct the port in the configuration"
        ) from error


def _cut_off(section: Lcus, laboratory: Laboratory | None) -> LcusRelay:
    port = SerialPort(
        resolved(section.port, laboratory),
        part="cut-off (lcus)",
        baud=lcus.BAUD,
        answer_timeout_s=WRITE_TIMEOUT_S,
    )
    return LcusRelay(port, channel=section.channel)


def build_trigger(section: TriggerSection, laboratory: Laboratory | None) -> Trigger:
    """Open a trigger; it fires nothing. Raises as `build_actuators`."""
    path = resolved(section.port, laboratory)
    if isinstance(section, SolenoidPair | Magnet):
        port = SerialPort(
            path,
            part=f"trigger ({section.driver})",
            baud=lcus.BAUD,
            answer_timeout_s=WRITE_TIMEOUT_S,
        )
        if isinstance(section, Magnet):
            return lcus.Holders(port, channel_a=section.channel, channel_b=None, energised="hold")
        return lcus.Holders(
            port,
            channel_a=section.channel_a,
            channel_b=section.channel_b,
            energised=section.energised,
        )
    port = SerialPort(
        path,
        part="trigger (trigger-box)",
        baud=TRIGGER_BOX_BAUD,
        answer_timeout_s=section.answer_timeout_s,
    )
    return TriggerBox(port, pulse_us=section.pulse_us)


def _regulator(section: AlicatSection, laboratory: Laboratory | None) -> AlicatPair:
    port = SerialPort(
        resolved(section.port, laboratory),
        part="regulator (alicat)",
        baud=alicat.BAUD,
        answer_timeout_s=section.answer_timeout_s,
        terminator=alicat.TERMINATOR,
    )
    return AlicatPair(port, unit_a=section.unit_a, unit_b=section.unit_b)


def build_slide(section: ZaberSection, laboratory: Laboratory | None) -> ZaberSlide:
    """Open a slide; nothing moves. Raises as `build_actuators`."""
    return ZaberSlide(
        resolved(section.port, laboratory),
        microsteps_per_mm=section.microsteps_per_mm,
        answer_timeout_s=section.answer_timeout_s,
    )
