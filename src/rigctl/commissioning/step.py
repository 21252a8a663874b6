"""One step of a commissioning: what to do, what must be seen, what it says something about."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from rigctl.config import Configuration
from rigctl.settings import ShotSettings


class Part(StrEnum):
    """What a step is about; after work on its wiring all steps of a part are asked for again."""

    CUT_OFF = "cut-off"
    TRIGGER = "trigger"
    REGULATOR = "regulator"
    SLIDE = "slide"
    CAMERA = "camera"
    INTERLOCKS = "interlocks"
    STOP = "stop"


class Act(StrEnum):
    """What the daemon does for a step, on request.

    `release`: releases a latched rig. `stop`: an emergency stop. `stop-release`: both. `refused`:
    arms, which the rig must refuse in the step's own words. `latched`: the rig must have stopped by
    itself, for a reason that is the step's; it is then released. `back`: releases a latched rig,
    arms and disarms. `set`: arms with raised settings and disarms. `set-stop`: the same, then
    stops. `fire`: one shot with the lowest settings. `unrecorded`: one that must end without a
    pulse. `rest`: one shot, then arms anew, which must wait for the cool-down.
    """

    RELEASE = "release"
    STOP = "stop"
    STOP_RELEASE = "stop-release"
    REFUSED = "refused"
    LATCHED = "latched"
    BACK = "back"
    SET = "set"
    SET_STOP = "set-stop"
    FIRE = "fire"
    UNRECORDED = "unrecorded"
    REST = "rest"


_MOVING = frozenset(
    {Act.REFUSED, Act.BACK, Act.SET, Act.SET_STOP, Act.FIRE, Act.UNRECORDED, Act.REST}
)


@dataclass(frozen=True, slots=True)
class Step:
    """One thing to be seen.

    Attributes
    ----------
    do, see
        What the person does, and what must be seen.
    act
        What the daemon does; None where the person does all.
    settings
        Those of an act that arms.
    refused_by
        Words of which the refusal must hold one.
    sections
        What of the configuration the step says something about, by dotted path; when one of them
        changes, the step is asked for again.
    firmware
        Whether the part's own word on its firmware counts likewise.
    latched_by
        Words of which the reason of the latch must hold one.
    """

    name: str
    part: Part
    title: str
    do: str
    see: str
    act: Act | None = None
    settings: ShotSettings | None = None
    refused_by: tuple[str, ...] = ()
    sections: tuple[str, ...] = ()
    firmware: bool = False
    latched_by: tuple[str, ...] = ()

    @property
    def may_move(self) -> bool:
        """Whether its act may move something, as arming does: none before the cut-off was seen.

        The refusals of the cut-off's own steps are tried with everything left as it is.
        """
        return self.act in _MOVING and self.part is not Part.CUT_OFF


def lowest(
    configuration: Configuration, *, share: float = 0.0, delay_us: float = 0.0
) -> ShotSettings:
    """Return the lowest settings of a rig, or those at a share of the way to the highest."""
    limits = configuration.limits

    def at(bounds: tuple[float, float]) -> float:
        return bounds[0] + share * (bounds[1] - bounds[0])

    angle = None if limits.angle_deg is None else limits.angle_deg[0]
    pressure = at(limits.pressure_kpa)
    return ShotSettings(
        pressure_a_kpa=pressure,
        pressure_b_kpa=pressure,
        offset_mm=at(limits.offset_mm),
        delay_us=delay_us,
        angle_a_deg=angle,
        angle_b_deg=angle,
    )
