"""A shot's result as other programs read it (commands.md)."""

from __future__ import annotations

from typing import Any

import numpy as np

from analysis.collision.force_law import hertz_duration, stated_modulus, yield_speed
from analysis.collision.operator import Body
from analysis.imaging.marker.markers import Markers
from analysis.imaging.views import View
from analysis.quantity import Quantity
from analysis.shot import MeasuredShot, RefusedShot
from analysis.tracking import Tracking

Json = dict[str, Any]


def shot_document(shot: MeasuredShot | RefusedShot) -> Json:
    """Return the result of a shot without its number: measured, or refused with the reason.

    `contact_time_s` counts from the shot's first frame; `contact_duration` reaches from there to
    the parting, null where the paths after contact do not show it. Signs as in section 7.1 of the
    thesis.
    """
    if isinstance(shot, RefusedShot):
        refused: Json = {"status": "refused", "step": shot.step}
        if shot.frame is not None:
            refused["frame"] = shot.frame
        return {**refused, "reason": shot.reason}
    impact = shot.impact
    return {
        "status": "measured",
        "contact_time_s": impact.contact_time.value,
        "contact_time_sigma_s": impact.contact_time.sigma,
        "contact_duration": _value(impact.duration),
        "normal": [float(n) for n in impact.normal],
        "normal_sigma": [float(n) for n in impact.normal_sigma],
        "v_n": impact.v_n.to_json(),
        "v_s": _value(impact.v_s),
        "v_n_after": impact.v_n_after.to_json(),
        "v_s_after": _value(impact.v_s_after),
        "e": impact.e.to_json(),
        "beta": _value(impact.beta),
        "frames_before": list(shot.used_before),
        "frames_after": list(shot.used_after),
        "scale_px_per_m": {v.value: s for v, s in shot.tracking.scales_px_per_m.items()},
        "notes": list(shot.notes),
        **expected_document(shot.bodies, impact.v_n.value),
    }


def expected_document(bodies: tuple[Body, Body], v_n: float) -> Json:
    """Return what the stated material makes expect of an impact at v_n, m/s; nothing without one.

    Under `expected`: `contact_duration_s` by Hertz, elastic, and `yield_speed_m_per_s`, null where
    no yield is stated.
    """
    modulus = stated_modulus(bodies)
    if modulus is None or v_n == 0.0:
        return {}
    lasts = hertz_duration(modulus, bodies) * abs(v_n) ** -0.2
    return {"expected": {"contact_duration_s": lasts, "yield_speed_m_per_s": yield_speed(bodies)}}


def _value(quantity: Quantity | None) -> Json | None:
    return None if quantity is None else quantity.to_json()


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
