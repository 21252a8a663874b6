from pathlib import Path

import cv2
import numpy as np
from rendered import setup_of, shot

from analysis.figures.shot import draw_shot
from analysis.shot import MeasuredShot, analyse_shot
from simulators.world import WorldDescription


def test_a_measured_shot_is_drawn_as_a_png_of_the_stated_size(tmp_path: Path) -> None:
    rendered = shot(40.0, 6.0, frames=12)
    measured = analyse_shot(rendered.frames, rendered.times_s, setup_of(WorldDescription()))
    assert isinstance(measured, MeasuredShot)
    path = tmp_path / "0001.png"
    draw_shot(path, "nylon, shot 1", rendered.frames, measured)
    picture = cv2.imread(str(path))
    assert picture is not None
    assert picture.shape == (836, 1452, 3)
    # Sphere a is drawn in sky blue, sphere b in orange (blue, green, red).
    for colour in ((0xE9, 0xB4, 0x56), (0x00, 0x9F, 0xE6)):
        assert (np.abs(picture.astype(int) - colour).max(axis=2) < 12).sum() > 200
