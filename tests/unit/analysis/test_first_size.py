"""The size of the spheres in a picture, where no scale is stated."""

from dataclasses import replace

import pytest
from rendered import RADIUS_PX, setup_of, shot

from analysis.imaging.edge.frame import EdgeSettings
from analysis.imaging.radii import view_radii
from analysis.imaging.views import View
from analysis.tracking import film_edges, followed_discs
from simulators.world import WorldDescription


@pytest.mark.parametrize(("pressure_kpa", "offset_mm"), [(40.0, 6.0), (50.0, 8.0), (60.0, 3.0)])
def test_a_mirror_that_is_left_out_does_not_change_it(
    pressure_kpa: float, offset_mm: float
) -> None:
    setup = setup_of(WorldDescription())
    front = replace(setup.camera, top_view_rows=None, top_origin_px=None, scale_px_per_m=None)
    filmed = shot(pressure_kpa, offset_mm)
    setup = replace(setup, camera=front)
    discs, _ = followed_discs(film_edges(filmed.frames, EdgeSettings()), filmed.times_s, setup, 0.3)
    assert view_radii(discs)[View.FRONT] == pytest.approx((RADIUS_PX, RADIUS_PX), abs=0.5)
