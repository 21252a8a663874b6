"""The next shot: settings within limits, the hit that they lead to, arming, and the fire."""

from __future__ import annotations

import math
import secrets
from dataclasses import dataclass

from nicegui import ui

from rigctl.page.desk import Desk, actor
from rigctl.page.parts.fields import CampaignField, NumberField, setting_fields
from rigctl.page.parts.readings import Impact
from rigctl.page.parts.tables import minus
from rigctl.page.parts.widgets import button
from rigctl.rig.arming import Armed
from rigctl.rig.states import LATCHED, RigState
from rigctl.rig.status import RigStatus
from rigctl.service.models import ShotOrder
from rigctl.settings import ShotSettings

SLIDES_FROM = 0.45
"""v_s / v_n about which contacts change from sticking to sliding: near it, a shot shows both."""
NEAR = 1.6
"""Within this factor of it."""


def expected(
    measured: Impact, then: ShotSettings, now: ShotSettings, diameter_mm: float
) -> tuple[float, float] | None:
    """Return approach speed, m/s, and the angle off head on, degrees; None where they would miss.

    The work of the pressure is kinetic energy: each sphere's speed grows as the root of its
    pressure. Spin, fall and the pushers' losses are left out, so it holds to some per cent.

    Parameters
    ----------
    measured, then
        A shot's coefficients, and the settings that it was fired with.
    """
    share = abs(now.offset_mm) / diameter_mm
    if measured.v_n is None or measured.v_s is None or share >= 1:
        return None
    speed = math.hypot(measured.v_n[0], measured.v_s[0]) * _push(now) / _push(then)
    angle = math.asin(share)
    return speed * math.cos(angle), math.degrees(angle)


def sentence(number: int, approach: float, angle: float) -> str:
    """Say what can be expected, after which shot."""
    slides = math.tan(math.radians(angle))
    if slides < SLIDES_FROM / NEAR:
        kind = "the surfaces will stick"
    elif slides <= SLIDES_FROM * NEAR:
        kind = "between sticking and sliding, which teaches most"
    else:
        kind = "the surfaces will slide"
    met = "head on" if angle < 1 else f"{angle:.0f}° off head on"
    return (
        f"You can expect an approach of {approach:.1f} m/s, {met}: {kind}. (Speed from shot "
        f"{number}; sticking as of nylon spheres without spin.)"
    )


def _push(settings: ShotSettings) -> float:
    return math.sqrt(settings.pressure_a_kpa) + math.sqrt(settings.pressure_b_kpa)


ARMABLE = frozenset({RigState.IDLE, RigState.ARMED})


@dataclass(frozen=True, slots=True)
class _Held:
    """A live token of this page. Its key goes with it: however often fire is pressed, one shot."""

    armed: Armed
    settings: ShotSettings
    key: str


class OrderForm:
    """Fields, and the buttons arm, fire and disarm; `show` follows the rig.

    `filled` are the settings that the fields start with; None: those that the rig has.
    """

    def __init__(self, desk: Desk, filled: ShotSettings | None = None) -> None:
        self._desk, self._rig = desk, desk.daemon.rig
        self._held: _Held | None = None
        self._arming = False
        self._fields: dict[str, NumberField] = setting_fields(
            desk.daemon.configuration.limits, filled or self._rig.status().settings
        )
        last = self._rig.status().last_shot
        self._campaign = CampaignField("first" if last is None else last.campaign or "")
        self._expected = ui.label().classes("expectation").props("data-testid=expected")
        self._said = ui.label().classes("note").props("data-testid=arming role=status")
        with ui.element("div").classes("order-actions"):
            self._arm = button(
                "Arm: check and make ready", self._on_arm, look="main fill", testid="arm"
            )
            self._fire = button("Fire", self._on_fire, look="main fire", testid="fire")
            self._disarm = button("Disarm", self._on_disarm, look="main line", testid="disarm")

    def show(self, status: RigStatus) -> None:
        """Say where arming stands and offer what can be done now."""
        if self._held is not None and status.token_expires_at != self._held.armed.expires_at:
            self._held = None
        armed = status.state is RigState.ARMED
        valid = self._campaign.valid and all(field.valid for field in self._fields.values())
        self._said.set_text(self._sentence(status))
        told = self._expectation(status) if valid else ""
        self._expected.set_text(told)
        self._expected.set_visibility(bool(told))
        self._arm.set_visibility(not armed)
        self._fire.set_visibility(armed)
        self._disarm.set_visibility(armed)
        self._arm.set_enabled(valid and not self._arming and status.state in ARMABLE)
        self._fire.set_enabled(armed and self._held is not None)
        free = not armed and not self._arming
        self._campaign.set_enabled(enabled=free)
        for field in self._fields.values():
            field.set_enabled(enabled=free)

    def _expectation(self, status: RigStatus) -> str:
        """Say how the shot will hit, by the last one; nothing before one was measured."""
        last, configuration = status.last_shot, self._desk.daemon.configuration
        if last is None or last.settings is None or configuration.apparatus != "pusher":
            return ""
        measured = self._desk.readings.of([last])
        if not measured:
            return ""
        found = expected(
            measured[0], last.settings, self._settings(), 1e3 * configuration.spheres[0].diameter_m
        )
        return "" if found is None else sentence(last.number, *found)

    def _settings(self) -> ShotSettings:
        return ShotSettings.model_validate(
            {name: field.value for name, field in self._fields.items()}
        )

    def _sentence(self, status: RigStatus) -> str:
        if self._arming:
            limit = self._desk.daemon.configuration.limits.settle_timeout_s
            return f"Setting pressure and offset, checking the interlocks; at most {limit:g} s …"
        if status.state in LATCHED:
            return "Nothing can be armed before the rig is released."
        if status.state is not RigState.ARMED or status.token_ends_s is None:
            busy = status.state is not RigState.IDLE
            return f"The rig is {status.state}." if busy else "Nothing moves before you arm."
        left = max(0.0, status.token_ends_s - status.read_at)
        for_what = "" if status.settings is None else f" for {words(status.settings)}"
        if self._held is None:
            return f"Armed{for_what} by somebody else, {left:.0f} s left."
        return f"Armed{for_what}: {left:.0f} s left."

    async def _on_arm(self) -> None:
        settings, who = self._settings(), actor()
        self._arming = True
        try:
            armed = await self._desk.act(lambda: self._rig.arm(settings, who), moves=True)
        finally:
            self._arming = False
        if armed is not None:
            self._held = _Held(armed, settings, secrets.token_hex(16))
            for warning in armed.warnings:
                ui.notify(warning, type="warning", timeout=10_000)

    async def _on_fire(self) -> None:
        held, who = self._held, actor()
        if held is None:
            return
        order = ShotOrder(arm_token=held.armed.token, campaign=self._campaign.value or None)
        await self._desk.act(
            lambda: self._rig.accept(
                order.arm_token,
                held.key,
                order.digest(),
                campaign=order.campaign,
                actor=who,
            ),
            moves=True,
            fires=True,
        )

    async def _on_disarm(self) -> None:
        who = actor()
        await self._desk.done(lambda: self._rig.disarm(who, "disarmed on the page"))


def words(settings: ShotSettings | None) -> str:
    """Return settings as a person says them; of an imported shot they may not be known."""
    if settings is None:
        return "settings not stated"
    text = (
        f"{settings.pressure_a_kpa:g} and {settings.pressure_b_kpa:g} kPa, "
        f"offset {settings.offset_mm:g} mm"
    )
    return text + (minus(f", b after {settings.delay_us:g} µs") if settings.delay_us else "")
