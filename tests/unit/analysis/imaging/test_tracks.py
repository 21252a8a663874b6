import numpy as np

from analysis.imaging.outlines import Outline
from analysis.imaging.shells import Circle
from analysis.imaging.tracks import Track
from analysis.imaging.views import View


def test_a_frame_without_outline_has_no_centre() -> None:
    outline = Outline(Circle(10.0, 12.0, 20.0, np.zeros((3, 3))), 1.0, np.zeros((0, 2)))
    seen = Track(View.FRONT, {2: outline})
    assert seen.centre(2) == (10.0, 12.0)
    assert seen.centre(3) is None
