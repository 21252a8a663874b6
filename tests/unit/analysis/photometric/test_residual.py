"""The modelled pixel against a sphere that is drawn point by point and then blurred."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.compiled import compiled
from analysis.photometric.render.covers import cover_canvas, paint_of
from analysis.photometric.render.residual import LOOK, cover_at, model_pixel, shade
from tests.unit.analysis.photometric.drawn import sight_of, sphere_image, stance_at

RADIUS, PLACE, LIMB, BLUR = 20.0, (31.4, 31.8), 0.6, 1.1
MARKER_PX = 5
"""Half side of the window about a marker."""


@compiled
def render(sight, stance, view, image):
    """Fill in every pixel that the sphere reaches."""
    canvas, corner, place = cover_canvas(sight, stance, view)
    paint, seen = paint_of(sight, stance, view, place[2]), np.zeros(LOOK)
    for i in range(canvas.shape[0]):
        for j in range(canvas.shape[2]):
            y, x = corner[0] + i, corner[1] + j
            u, v = (y - place[0]) / place[2], (x - place[1]) / place[2]
            if shade(sight.look.discs[view], sight.look.surfaces[view], u, v, seen):
                cover = cover_at(canvas, i, j)
                image[y, x] = model_pixel(seen, cover, sight.scene.background[y, x], paint)


def modelled(markers):
    """Return the modelled image of a sphere, NaN where it does not reach."""
    blank = np.zeros((64, 64), np.uint8)
    sight = sight_of(blank, markers, radius=RADIUS, noise=1.0, limb=LIMB, blur=BLUR)
    image = np.full((64, 64), np.nan)
    render(sight, stance_at(*PLACE, RADIUS), 0, image)
    return image


@pytest.mark.parametrize("share", [0.0, 0.5, 0.8, 0.96, 0.99])
def test_a_marker_lies_where_it_was_drawn_although_the_light_falls_off_across_it(share):
    marker = np.array([[0.0, share, np.sqrt(1 - share**2)]])
    drawn = sphere_image(place=PLACE, radius=RADIUS, markers=marker, limb=LIMB, blur=BLUR)
    plain = sphere_image(place=PLACE, radius=RADIUS, markers=marker[:0], limb=LIMB, blur=BLUR)
    y, x = round(PLACE[0]), round(PLACE[1] + share * RADIUS)
    near = np.s_[y - MARKER_PX : y + MARKER_PX + 1, x - MARKER_PX : x + MARKER_PX + 1]
    dark, found = (plain - drawn)[near], (modelled(marker[:0]) - modelled(marker))[near]
    inside = np.isfinite(found)
    across = np.arange(x - MARKER_PX, x + MARKER_PX + 1.0)
    shift = ((found - dark) * (across - x))[inside].sum() / dark[inside].sum()
    # A product of blurred light and blurred cover would be off by 0.1 px where the limb is near.
    assert abs(shift) < (0.015 if share < 0.9 else 0.03)
    assert np.abs(found - dark)[inside].max() < 0.7
