"""Marks dragged on a film's picture: the part, and the scale that ring and line give."""

from __future__ import annotations

import pytest

from rigctl.page.own.marks import Marks, diameter_by_line, scale_words, unlike_words, window_of

SIZE = (160, 360)


def test_a_part_is_kept_in_whole_pixels_of_the_picture() -> None:
    given = {"part": [-3.2, 10.4, 100.0, 400.0], "ring": None, "line": None}
    marks = Marks.from_json(given, SIZE)
    assert marks.part is not None
    assert window_of(marks.part, SIZE) == (0, 10, 97, 350)
    assert Marks.from_json({"part": [0, 0, 160, 360]}, SIZE).part is None


@pytest.mark.parametrize("ring", [[1.0, 2.0], "ring", [1.0, 2.0, float("nan")]])
def test_what_is_no_mark_is_refused(ring: object) -> None:
    with pytest.raises(ValueError, match="numbers are needed"):
        Marks.from_json({"part": None, "ring": ring, "line": None}, SIZE)


def test_a_line_of_100_px_over_250_mm_makes_a_ring_of_36_px_a_ball_of_90_mm() -> None:
    marks = Marks(ring=(80.0, 100.0, 18.0), line=(20.0, 300.0, 80.0, 220.0))
    found = diameter_by_line(marks, 250.0)
    assert found is not None
    assert found.value == pytest.approx(90.0)
    # Each end by eye to a pixel: 1.41 px of 36 and of 100 px.
    assert found.sigma == pytest.approx(90.0 * (2 / 36**2 + 2 / 100**2) ** 0.5)
    assert diameter_by_line(marks.without_ring(), 250.0) is None


def test_a_line_that_contradicts_the_stated_diameter_is_said() -> None:
    marks = Marks(ring=(80.0, 100.0, 18.0), line=(20.0, 300.0, 120.0, 300.0))
    assert "it agrees" in scale_words(marks, 90.0, diameter_by_line(marks, 250.0))
    said = scale_words(marks, 40.0, diameter_by_line(marks, 250.0))
    assert "wrong by 125%" in said
    assert "36.0 px = 40 mm" in said


def test_a_ball_unlike_the_ring_is_said() -> None:
    marks = Marks(ring=(80.0, 100.0, 18.0))
    assert unlike_words(marks, 35.2) is None
    assert "20.0 px across, the ring 36.0 px" in (unlike_words(marks, 20.0) or "")
    assert unlike_words(Marks(), 20.0) is None
