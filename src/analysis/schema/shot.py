"""A shot's result and its poses, as result files, `rigctl analyse --json` and REST hold them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import SerializerFunctionWrapHandler, model_serializer
from pydantic.dataclasses import dataclass

from analysis.quantity import Measured
from analysis.schema.codec import BESIDE, STRICT, NotNegative

Three = tuple[float, float, float]


@dataclass(frozen=True, slots=True, config=STRICT)
class Pose:
    """One sphere in one frame; None is what was not measured, and an error of 0 none is stated.

    Attributes
    ----------
    t_s
        From the shot's first frame, s.
    position_m, sigma_m
        Along X, Y and Z of the rig.
    quaternion
        Scalar first, body to rig axes.
    sigma_rot_rad
        About each axis.
    cov_rot_rad2
        xx, yy, zz, xy, xz and yz of a small turn in rig axes; None: the same about each axis.
    """

    sphere: Literal["a", "b"]
    frame: int
    t_s: float
    position_m: tuple[float | None, float | None, float | None]
    sigma_m: tuple[NotNegative | None, NotNegative | None, NotNegative | None]
    quaternion: tuple[float, float, float, float] | None
    sigma_rot_rad: NotNegative | None
    cov_rot_rad2: tuple[float, float, float, float, float, float] | None = None


@dataclass(frozen=True, slots=True, config=STRICT)
class Expected:
    """What the stated material makes expect: Hertz's duration, and where it yields, if known."""

    contact_duration_s: NotNegative
    yield_speed_m_per_s: NotNegative | None


@dataclass(frozen=True, slots=True, config=BESIDE, kw_only=True)
class MeasuredResult:
    """A measured collision; signs as in section 7.1 of the thesis.

    Attributes
    ----------
    contact_time_s, contact_time_sigma_s
        First touch, from the shot's first frame, s.
    contact_duration
        From there to the parting; None where the paths after contact do not show it.
    normal, normal_sigma
        Unit vector from a to b and its standard errors, rig axes.
    v_n, v_s, v_n_after, v_s_after
        m/s; surface velocities are None where a spin is not determined.
    e, beta
        Restitution; beta is None where v_s is compatible with zero.
    frames_before, frames_after
        That entered the fit on either side of the contact.
    scale_px_per_m
        By view.
    notes
        What was left out, and why.
    expected
        None, and no key in JSON, where no material is stated.
    """

    status: Literal["measured"] = "measured"
    contact_time_s: float
    contact_time_sigma_s: NotNegative
    contact_duration: Measured | None
    normal: Three
    normal_sigma: Three
    v_n: Measured
    v_s: Measured | None
    v_n_after: Measured
    v_s_after: Measured | None
    e: Measured
    beta: Measured | None
    frames_before: tuple[int, ...]
    frames_after: tuple[int, ...]
    scale_px_per_m: Mapping[str, NotNegative]
    notes: tuple[str, ...]
    expected: Expected | None = None

    @model_serializer(mode="wrap")
    def _fields(self, inner: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return _without_none(inner(self), "expected")


@dataclass(frozen=True, slots=True, config=BESIDE, kw_only=True)
class RefusedResult:
    """A shot that cannot be analysed: the step that failed, in which frame, and why.

    `frame` has no key in JSON where the reason is that of no single one.
    """

    status: Literal["refused"] = "refused"
    step: str
    frame: int | None = None
    reason: str

    @model_serializer(mode="wrap")
    def _fields(self, inner: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return _without_none(inner(self), "frame")


def _without_none(fields: dict[str, Any], key: str) -> dict[str, Any]:
    return {k: v for k, v in fields.items() if k != key or v is not None}
