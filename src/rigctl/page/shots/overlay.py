"""What the analysis found in a frame, drawn over it as SVG in pixels of the frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from analysis.figures.palette import SPHERE_A, SPHERE_B

Json = Mapping[str, Any]
COLOURS = {"a": SPHERE_A, "b": SPHERE_B}
WIDTH = 0.8
NORMAL_LENGTH = 16.0
"""Of the arrow along the normal, pixels."""
NORMAL_COLOUR = "#F0E442"
LAYERS = ("outlines", "markers", "tracks", "normal")


@dataclass(frozen=True, slots=True)
class Overlays:
    """A result's drawing, by layers.

    Attributes
    ----------
    frames
        What was found in each frame: outlines and markers in pixels (row, column).
    contact_frame
        The first frame after the first touch; None where the shot was not measured.
    normal
        Unit vector from a to b at first touch, rig axes: X down and Y to the right in the front
        view.
    """

    frames: Sequence[Json]
    contact_frame: int | None
    normal: Sequence[float] | None

    @classmethod
    def of(cls, result: Json) -> Overlays:
        """Return what a result holds; a refused shot holds nothing."""
        time_s, rate = result.get("contact_time_s"), result.get("frame_rate_hz")
        contact = None if time_s is None or rate is None else int(time_s * rate) + 1
        return cls(result.get("overlay", []), contact, result.get("normal"))

    def drawing(self, frame: int, layers: Sequence[str]) -> str:
        """Return the SVG over one frame, counted from 0, with the layers that are asked for."""
        if frame >= len(self.frames):
            return ""
        found = self.frames[frame]
        parts: list[str] = []
        if "tracks" in layers:
            parts += self._tracks(frame)
        if "outlines" in layers:
            parts += [_circle(one, one["radius"]) + _cross(one) for one in found["outlines"]]
        if "markers" in layers:
            parts += [_circle(one, 1.8) for one in found["markers"]]
        if "normal" in layers:
            parts += self._normal(found)
        return "".join(parts)

    def _tracks(self, frame: int) -> list[str]:
        paths: dict[tuple[str, str], list[str]] = {}
        for found in self.frames[: frame + 1]:
            for one in found["outlines"]:
                point = f"{one['column'] + 0.5:.2f},{one['row'] + 0.5:.2f}"
                paths.setdefault((one["sphere"], one.get("view", "")), []).append(point)
        return [
            f'<polyline points="{" ".join(points)}" fill="none" stroke="{COLOURS[sphere]}" '
            f'stroke-width="{WIDTH}" stroke-dasharray="2 1.5"/>'
            for (sphere, _), points in paths.items()
        ]

    def _normal(self, found: Json) -> list[str]:
        """Return the normal at first touch between the spheres of the front view."""
        ends = {one["sphere"]: one for one in found["outlines"] if one.get("view") == "front"}
        if self.normal is None or set(ends) != {"a", "b"}:
            return []
        column = (ends["a"]["column"] + ends["b"]["column"]) / 2 + 0.5
        row = (ends["a"]["row"] + ends["b"]["row"]) / 2 + 0.5
        down, across = self.normal[0] * NORMAL_LENGTH, self.normal[1] * NORMAL_LENGTH
        return [
            f'<line x1="{column - across:.2f}" y1="{row - down:.2f}" x2="{column + across:.2f}" '
            f'y2="{row + down:.2f}" stroke="{NORMAL_COLOUR}" stroke-width="{WIDTH}"/>'
            f'<circle cx="{column + across:.2f}" cy="{row + down:.2f}" r="1.3" '
            f'fill="{NORMAL_COLOUR}"/>'
        ]


def _circle(one: Json, radius: float) -> str:
    return (
        f'<circle cx="{one["column"] + 0.5:.2f}" cy="{one["row"] + 0.5:.2f}" r="{radius:.2f}" '
        f'fill="none" stroke="{COLOURS[one["sphere"]]}" stroke-width="{WIDTH}"/>'
    )


def _cross(one: Json) -> str:
    x, y = one["column"] + 0.5, one["row"] + 0.5
    return (
        f'<path d="M{x - 2:.2f} {y:.2f}h4M{x:.2f} {y - 2:.2f}v4" '
        f'stroke="{COLOURS[one["sphere"]]}" stroke-width="{WIDTH}"/>'
    )
