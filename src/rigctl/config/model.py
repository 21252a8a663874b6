"""The base of every configuration model: strict, complete, unchangeable."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field


class StrictModel(BaseModel):
    """A section of the configuration: nothing is coerced, unknown fields and NaN are refused."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


def _rising(bounds: tuple[float, float]) -> tuple[float, float]:
    if bounds[0] > bounds[1]:
        raise ValueError("the lower bound lies above the upper bound")
    return bounds


Range = Annotated[tuple[float, float], AfterValidator(_rising)]
"""Closed interval [lowest, highest], in the unit that the field's name carries."""

Seconds = Annotated[float, Field(gt=0, le=3600)]
"""A bound on a wait: longer than nothing and never without end."""

Port = Annotated[str, Field(min_length=1)]
"""A device path, a pyserial URL, or `sim:ROLE` on a simulated rig."""

SIMULATED = "sim:"
"""What the port of a simulated device begins with."""
