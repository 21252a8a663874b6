"""A plot without shots says what to do first; one with shots shows them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import pytest

from rigctl.page.parts.impact_plots import over_incidence, over_speed
from rigctl.page.parts.readings import Impact

FLAT = Impact(1, v_n=(-3.0, 0.001), v_s=(0.0, 0.001), e=(0.74, 0.001), beta=(0.0, 50.0))
Plot = Callable[[Sequence[Impact], str], dict[str, Any]]


@pytest.mark.parametrize("plot", [over_speed, over_incidence])
def test_without_a_shot_the_plot_says_to_fire_one(plot: Plot) -> None:
    drawn = plot([], "first")
    assert "fire one" in drawn["layout"]["annotations"][0]["text"]
    assert not drawn["layout"]["xaxis"]["visible"]


def test_shots_that_do_not_slide_are_asked_for_an_offset_where_only_sliding_tells() -> None:
    assert "offset" in over_incidence([FLAT], "first")["layout"]["annotations"][0]["text"]
    assert "annotations" not in over_speed([FLAT], "first")["layout"]


def test_the_line_at_minus_one_says_that_it_is_no_friction() -> None:
    slides = Impact(1, v_n=(-3.0, 0.001), v_s=(3.0, 0.001), e=(0.74, 0.001), beta=(-0.5, 0.01))
    (line,) = over_incidence([slides], "first")["layout"]["shapes"]
    assert (line["y0"], line["label"]["text"]) == (-1.0, "β = −1: no friction")


def test_speeds_that_hardly_differ_are_drawn_over_a_tenth_of_a_metre_a_second() -> None:
    low, high = over_speed([FLAT], "first")["layout"]["xaxis"]["range"]
    assert high - low == pytest.approx(0.1)
    assert low < 3.0 < high
