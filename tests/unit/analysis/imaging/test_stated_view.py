"""Of a camera without a mirror only the stated rows are looked at."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rendered import setup_of, shot

from analysis.imaging.stated_view import first_row, stated_view
from analysis.imaging.views import View, view_geometries
from analysis.setup import Setup
from analysis.shot import AnalysisOptions, MeasuredShot, Method, RefusedShot, analyse_shot
from simulators.world import WorldDescription


def without_mirror(setup: Setup) -> Setup:
    return replace(setup, camera=replace(setup.camera, top_view_rows=None, top_origin_px=None))


def test_the_view_alone_keeps_its_places() -> None:
    setup = without_mirror(setup_of(WorldDescription()))
    frames = shot(40.0, 6.0).frames
    seen, alone = stated_view(frames, setup)
    assert first_row(setup.camera) == 88
    np.testing.assert_array_equal(seen, frames[:, 88:192])
    (before,), (after,) = view_geometries(setup.camera), view_geometries(alone.camera)
    assert before.origin[0] - after.origin[0] == 88
    assert after.rows == (0, 104)


def test_two_views_and_whole_frames_stay_as_they_are() -> None:
    setup = setup_of(WorldDescription())
    frames = shot(40.0, 6.0).frames
    assert stated_view(frames, setup) == (frames, setup)
    whole = replace(without_mirror(setup).camera, front_view_rows=(0, 192))
    assert stated_view(frames, replace(setup, camera=whole))[0] is frames


@pytest.mark.parametrize("method", ["photometric", "thesis"])
def test_what_other_pixels_show_changes_nothing(method: Method) -> None:
    setup = without_mirror(setup_of(WorldDescription()))
    filmed = shot(40.0, 6.0)
    noisy = filmed.frames.copy()
    noisy[:, :88] = np.random.default_rng(0).integers(0, 255, noisy[:, :88].shape)
    options = AnalysisOptions(method=method)
    shots = [analyse_shot(each, filmed.times_s, setup, options) for each in (filmed.frames, noisy)]
    clean, other = shots
    assert isinstance(clean, MeasuredShot), clean
    assert isinstance(other, MeasuredShot), other
    assert other.impact.e == clean.impact.e
    rows = [o.circle.row for o in clean.tracking.spheres[0][View.FRONT].outlines.values()]
    assert 88 < min(rows) < max(rows) < 192


def test_a_refusal_has_places_in_the_whole_frame() -> None:
    setup = without_mirror(setup_of(WorldDescription()))
    filmed = shot(40.0, 6.0)
    left = filmed.frames.copy()
    left[:, :, 120:] = left[:, :1, 120:]
    refused = analyse_shot(left, filmed.times_s, setup, AnalysisOptions(method="thesis"))
    assert isinstance(refused, RefusedShot)
    assert all(88 <= row <= 200 for row, _, _ in refused.discs)
