"""The pixels that count where the set-up states one view: no others are looked at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from analysis.arrays import Grey
from analysis.imaging.marker.markers import FilmMarkers
from analysis.imaging.outlines import Outline
from analysis.imaging.tracks import Track
from analysis.imaging.views import View, view_geometries
from analysis.setup import WHOLE_FRAME, CameraSetup, Setup

LEAST_ROWS = 8
"""Of a picture."""


def first_row(camera: CameraSetup) -> int:
    """Return the first row that counts; of two views all do, as spheres rise before a mirror."""
    alone = camera.top_view_rows is None and _counts(camera) != camera.height_px
    return camera.front_view_rows[0] if alone else 0


def _counts(camera: CameraSetup) -> int:
    """Return how many rows the view of a camera without a mirror has; all where they are few."""
    first, last = camera.front_view_rows
    return last - first if last - first >= LEAST_ROWS else camera.height_px


def stated_view(frames: Grey, setup: Setup) -> tuple[Grey, Setup]:
    """Return frames that hold nothing but the view of a camera without a mirror, and their set-up.

    Parameters
    ----------
    frames
        Shape (frames, rows, columns).
    """
    camera = setup.camera
    first, last = camera.front_view_rows
    if camera.top_view_rows is not None or _counts(camera) == camera.height_px:
        return frames, setup
    (front,) = view_geometries(camera)
    alone = replace(
        camera,
        height_px=last - first,
        front_view_rows=WHOLE_FRAME,
        front_origin_px=(front.origin[0] - first, front.origin[1]),
    )
    return frames[:, first:last].copy(), replace(setup, camera=alone)


def lowered(tracks: Mapping[View, Track], rows: int) -> dict[View, Track]:
    """Return the outlines of a sphere so many rows lower."""
    return {
        view: Track(view, {k: _lowered(each, rows) for k, each in track.outlines.items()})
        for view, track in tracks.items()
    }


def _lowered(outline: Outline, rows: int) -> Outline:
    circle = replace(outline.circle, row=outline.circle.row + rows)
    return replace(outline, circle=circle, points=outline.points + np.array([rows, 0.0]))


def lowered_markers(markers: FilmMarkers, rows: int) -> FilmMarkers:
    """Return the markers of a sphere so many rows lower."""
    ellipses = markers.every.ellipses.copy()
    ellipses[:, 0] += rows
    return replace(markers, every=replace(markers.every, ellipses=ellipses))
