"""Poses of a measured shot in its result file, one object a sphere and frame, and how they err.

Same content as poses.csv. A value that was not measured is null: JSON has neither NaN nor infinity.
An error that is not stated is 0, as in the exchange folder.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any, Literal

from analysis.document import shot_document
from analysis.exchange.pose_table import PoseRow, measured_poses
from analysis.schema.codec import read, read_all, written_all
from analysis.schema.shot import Pose
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
    """Return the JSON of the poses of spheres a and b."""
    return written_all(Pose, [_pose(name, row) for name, rows in spheres.items() for row in rows])


def _pose(sphere: str, row: PoseRow) -> Pose:
    x, y, z = map(_finite, row.position)
    u, v, w = map(_sigma, row.position_sigma)
    turned = row.quaternion
    error = None if turned is None else _sigma(row.rotation_sigma)
    name: Literal["a", "b"] = "b" if sphere == "b" else "a"
    place = (x, y, z), (u, v, w)
    return Pose(name, row.frame, row.t_s, *place, turned, error, row.turn_covariance)


def poses_of(
    document: Sequence[Mapping[str, Any]], slow: SlowErrors | None = None
) -> dict[str, list[PoseRow]]:
    """Return the poses that `poses_document` wrote, with the slow errors of their shot.

    Raises
    ------
    ValueError
        The document has another form.
    """
    spheres: dict[str, list[PoseRow]] = {"a": [], "b": []}
    own = None if slow is None else (slow.position_m, slow.rotation_rad)
    for pose in read_all(Pose, document):
        x, y, z = (math.nan if v is None else v for v in pose.position_m)
        u, v, w = map(_stated, pose.sigma_m)
        turn_error = _stated(pose.sigma_rot_rad)
        turn = pose.quaternion, turn_error, own, pose.cov_rot_rad2
        spheres[pose.sphere].append(PoseRow(pose.frame, pose.t_s, (x, y, z), (u, v, w), *turn))
    return spheres


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _sigma(value: float) -> float | None:
    return 0.0 if math.isnan(value) else _finite(value)


def _stated(value: float | None) -> float:
    """Return a standard error: infinite where nothing was measured, NaN where none is stated."""
    return math.inf if value is None else value or math.nan


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
    return read(SlowErrors, document)
