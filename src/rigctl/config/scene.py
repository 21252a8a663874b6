"""Where the two views lie in the frame."""

from __future__ import annotations

from analysis.setup import Pixel, Rows, Scale
from rigctl.config.model import StrictModel


class Optics(StrictModel):
    """Where the two views lie in the frame and where X = Y = Z = 0 appears in each.

    They are a part of `analysis.setup.CameraSetup`, which checks them beside the frame's size.
    Without top-view keys the rig has no mirror. A missing scale is taken from the spheres'
    diameter in the images, a missing origin is chosen by the analysis.
    """

    front_view_rows: Rows
    top_view_rows: Rows | None = None
    front_origin_px: Pixel | None = None
    top_origin_px: Pixel | None = None
    scale_px_per_m: Scale | None = None
