"""How fast and how obliquely the next shot will hit, from one that was measured."""

from __future__ import annotations

import math

from rigctl.page.parts.readings import Impact
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
    return f"You can expect an approach of {approach:.1f} m/s, {met}: {kind}. (From shot {number}.)"


def _push(settings: ShotSettings) -> float:
    return math.sqrt(settings.pressure_a_kpa) + math.sqrt(settings.pressure_b_kpa)
