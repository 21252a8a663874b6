"""Poses of a measured shot in its result file, one object a sphere and frame, and how they err.

Same content as poses.csv. A value that was not measured is null: JSON has neither NaN nor infinity.
An error that is not stated is 0, as in the exchange folder.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from analysis.document import shot_document
from analysis.exchange.pose_table import PoseRow, measured_poses
from analysis.setup import SlowErrors
from analysis.shot import MeasuredShot, RefusedShot
from rigctl.documents import Json


def measured_document(shot: MeasuredShot | RefusedShot) -> Json:
    """Return what is kept of a shot: its result, and the poses that a fit is made of.

    As in commands.md, with `poses` and `slow_errors` where it was measured.
    """
    document = shot_document(shot)
    if isinstance(shot, MeasuredShot):
        document["poses"] = poses_document(measured_poses(shot))
        document["slow_errors"] = slow_errors_document(shot.slow)
    return document


def poses_document(spheres: Mapping[str, Sequence[PoseRow]]) -> list[Json]:
    """Return the poses of spheres a and b as JSON.

    Each object has `sphere`, `frame`, `t_s` from the shot's first frame, `position_m` and
    `sigma_m` along X, Y, Z of the rig, `quaternion` (scalar first, body to rig axes) and
    `sigma_rot_rad` about each axis.
    """
    return [
        {
            "sphere": sphere,
            "frame": row.frame,
            "t_s": row.t_s,
            "position_m": [_finite(x) for x in row.position],
            "sigma_m": [_sigma(x) for x in row.position_sigma],
            "quaternion": None if row.quaternion is None else list(row.quaternion),
            "sigma_rot_rad": None if row.quaternion is None else _sigma(row.rotation_sigma),
        }
        for sphere, rows in spheres.items()
        for row in rows
    ]


def poses_of(
    document: Sequence[Mapping[str, Any]], slow: SlowErrors | None = None
) -> dict[str, list[PoseRow]]:
    """Return the poses that `poses_document` wrote, with the slow errors of their shot.

    Raises
    ------
    KeyError, TypeError, ValueError
        The document has another form.
    """
    spheres: dict[str, list[PoseRow]] = {"a": [], "b": []}
    for row in document:
        x, y, z = (math.nan if v is None else float(v) for v in row["position_m"])
        u, v, w = (_stated(s) for s in row["sigma_m"])
        turned = row["quaternion"]
        spheres[row["sphere"]].append(
            PoseRow(
                frame=int(row["frame"]),
                t_s=float(row["t_s"]),
                position=(x, y, z),
                position_sigma=(u, v, w),
                quaternion=None if turned is None else _four(turned),
                rotation_sigma=_stated(row["sigma_rot_rad"]),
                slow=None if slow is None else (slow.position_m, slow.rotation_rad),
            )
        )
    return spheres


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _sigma(value: float) -> float | None:
    return 0.0 if math.isnan(value) else _finite(value)


def _stated(value: object) -> float:
    """Return a standard error: infinite where nothing was measured, NaN where none is stated."""
    if value is None:
        return math.inf
    return float(str(value)) or math.nan


def _four(values: Sequence[float]) -> tuple[float, float, float, float]:
    w, x, y, z = map(float, values)
    return w, x, y, z


def slow_errors_document(slow: SlowErrors) -> Json:
    """Return slow errors as a result holds them."""
    return asdict(slow)


def slow_errors_of(document: Mapping[str, Any]) -> SlowErrors:
    """Return the slow errors of a result.

    Raises
    ------
    ValueError
        The document has another form.
    """
    return SlowErrors(**document)
