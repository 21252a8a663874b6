import cv2
import drawings
import numpy as np
import pytest

from analysis.imaging.edge.facet import EdgePoints
from analysis.qualification.locating import canny_edges, ridges, sobel_edges

PLACE = (45.3, 60.7, 20.0)


def off_limb(points: EdgePoints) -> np.ndarray:
    return np.hypot(points.row - PLACE[0], points.column - PLACE[1]) - PLACE[2]


@pytest.mark.parametrize("find", [sobel_edges, canny_edges])
def test_ridges_follow_the_limb_all_round_within_a_pixel(find) -> None:
    points = find(drawings.grey(drawings.draw([PLACE])), 10.0)
    assert np.abs(off_limb(points)).max() < 1.0
    angle = np.arctan2(points.column - PLACE[1], points.row - PLACE[0])
    assert np.diff(np.sort(angle)).max() < np.radians(5)
    inward = (PLACE[0] - points.row) * points.normal_row
    inward += (PLACE[1] - points.column) * points.normal_column
    assert (inward / PLACE[2]).min() > 0.9


def test_on_a_slope_both_gradients_are_its_slope() -> None:
    rows, columns = np.mgrid[:40, :50].astype(float)
    roof = 100.0 - 3.0 * np.abs(rows - 20) + 0.0 * columns
    for find in (sobel_edges, canny_edges):
        points = find(roof, 1.0)
        assert points.strength.max() == pytest.approx(3.0, abs=1e-6)


def test_canny_marks_what_opencv_marks_on_the_same_gradient() -> None:
    frame = drawings.grey(drawings.draw([PLACE], markers=[(42.0, 55.0, 4.0)]), noise=1.0)
    points = canny_edges(frame, 8.0)
    ours = np.zeros(frame.shape, dtype=bool)
    ours[points.pixel_row, points.pixel_column] = True
    smooth = cv2.GaussianBlur(frame.astype(np.float64), (0, 0), 1.0)
    g_r, g_c = np.gradient(smooth)
    theirs = (
        cv2.Canny(
            (16 * g_c).astype(np.int16), (16 * g_r).astype(np.int16), 51.2, 128.0, L2gradient=True
        )
        > 0
    )
    near = cv2.dilate(theirs.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    assert (ours & near).sum() / ours.sum() > 0.97
    near = cv2.dilate(ours.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    assert (theirs & near).sum() / theirs.sum() > 0.97


def test_canny_drops_a_faint_ridge_that_touches_no_strong_one() -> None:
    frame = np.full((60, 80), 100.0)
    frame[20:, :] += 40.0
    frame[45:, 30:50] += 6.0
    kept = canny_edges(frame, 10.0)
    assert set(kept.pixel_row.tolist()) <= {18, 19, 20, 21}
    assert canny_edges(frame, 2.0).row.max() > 40


def test_a_flat_gradient_has_no_ridge() -> None:
    assert not ridges(np.zeros((8, 9)), np.zeros((8, 9))).any()
