"""Falls that a rig's own magnet lets go, each a shot of its store."""

from __future__ import annotations

from pathlib import Path

from analysis.qualification.drop import whole_falls
from rigctl.config import load
from rigctl.errors import ConfigurationError
from rigctl.local import opened
from rigctl.qualifying.runs import DropFrames
from rigctl.settings import ShotSettings

NOTHING_SET = ShotSettings(pressure_a_kpa=0.0, pressure_b_kpa=0.0, offset_mm=0.0)
"""A magnet has neither pressure nor offset."""


def fired_drops(config: Path, count: int) -> list[DropFrames]:
    """Fire shots one after another; each is kept in the store as any other.

    Raises
    ------
    ConfigurationError
        The apparatus is none that drops a sphere.
    RigError
        The rig refused, or a shot came without frames.
    ShotRefusedError
        Frames do not show a whole sphere for long enough.
    """
    section = load(config)
    if section.apparatus != "drop":
        raise ConfigurationError(
            "drops no sphere",
            part=str(config),
            value=f"apparatus = {section.apparatus!r}",
            limit="drop",
            todo="name the file of another apparatus",
        )
    diameter, gravity = section.spheres[0].diameter_m, section.environment.gravity_m_per_s2
    runs = []
    with opened(config) as rig:
        for _ in range(count):
            frames, times_s = rig.filmed(NOTHING_SET)
            part = whole_falls(frames)
            runs.append(DropFrames(frames[part], times_s[part], diameter, gravity))
    return runs
