"""A shot's result as other programs read it (commands.md)."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.collision.force_law import hertz_duration, stated_modulus, yield_speed
from analysis.collision.operator import Body
from analysis.imaging.marker.markers import Markers
from analysis.imaging.views import View
from analysis.schema.codec import Json, written
from analysis.schema.shot import Expected, MeasuredResult, RefusedResult
from analysis.shot import MeasuredShot, RefusedShot
from analysis.tracking import Tracking


def shot_document(shot: MeasuredShot | RefusedShot) -> Json:
    """Return the JSON of a shot's result without its number: measured, or refused."""
    return written(shot_result(shot))


def shot_result(shot: MeasuredShot | RefusedShot) -> MeasuredResult | RefusedResult:
    """Return the result of a shot without its number: measured, or refused with the reason."""
    if isinstance(shot, RefusedShot):
        return RefusedResult(step=shot.step, frame=shot.frame, reason=shot.reason)
    impact = shot.impact
    return MeasuredResult(
        contact_time_s=impact.contact_time.value,
        contact_time_sigma_s=impact.contact_time.sigma,
        contact_duration=impact.duration,
        normal=_three(impact.normal),
        normal_sigma=_three(impact.normal_sigma),
        v_n=impact.v_n,
        v_s=impact.v_s,
        v_n_after=impact.v_n_after,
        v_s_after=impact.v_s_after,
        e=impact.e,
        beta=impact.beta,
        frames_before=shot.used_before,
        frames_after=shot.used_after,
        scale_px_per_m={v.value: s for v, s in shot.tracking.scales_px_per_m.items()},
        notes=shot.notes,
        expected=expected(shot.bodies, impact.v_n.value),
    )


def expected(bodies: tuple[Body, Body], v_n: float) -> Expected | None:
    """Return what the stated material makes expect of an impact at v_n, m/s; None without one."""
    modulus = stated_modulus(bodies)
    if modulus is None or v_n == 0.0:
        return None
    return Expected(hertz_duration(modulus, bodies) * abs(v_n) ** -0.2, yield_speed(bodies))


def _three(values: Floats) -> tuple[float, float, float]:
    x, y, z = map(float, values)
    return x, y, z


def overlay_document(tracking: Tracking, count: int) -> list[Json]:
    """Return what to draw over each of so many frames: outlines and markers, in pixels."""
    frames: list[Json] = []
    for k in range(count):
        outlines = [
            {
                "sphere": name,
                "view": view.value,
                "row": outline.circle.row,
                "column": outline.circle.column,
                "radius": outline.circle.radius,
            }
            for name, sphere in zip("ab", tracking.spheres, strict=True)
            for view, track in sphere.items()
            if (outline := track.outlines.get(k)) is not None
        ]
        markers = [
            marker
            for i, name in enumerate("ab")
            if (seen := tracking.markers[i].get(k)) is not None
            for marker in _markers(name, seen, _names(tracking, i, k))
        ]
        frames.append({"frame": k, "outlines": outlines, "markers": markers})
    return frames


def _names(tracking: Tracking, sphere: int, frame: int) -> list[int]:
    """Return each sighting's marker in the sphere's pattern, -1 where it has none."""
    turned = tracking.orientations[sphere]
    index = np.flatnonzero(turned.frames == frame)
    return [] if index.size == 0 else [int(m) for m in turned.matches[int(index[0])]]


def _markers(sphere: str, seen: Markers, names: list[int]) -> list[Json]:
    known = names or [-1] * len(seen)
    return [
        {
            "sphere": sphere,
            "view": (View.FRONT if front else View.TOP).value,
            "marker": None if name < 0 else name,
            "row": row,
            "column": column,
        }
        for front, (row, column), name in zip(
            seen.front, seen.ellipses[:, :2].tolist(), known, strict=True
        )
    ]
