"""Discs that are likelier balls beside others like them."""

import math

import cv2
import drawings
import numpy as np
import pytest

from analysis.balls.discs import finding
from analysis.balls.discs.company import company
from analysis.balls.discs.disc import Disc
from analysis.balls.discs.finding import find_balls


def disc(row: float, column: float, radius: float = 20.0) -> Disc:
    return Disc(row, column, radius, 0.1, 0.1, 0.1, 1.0, -30.0)


def test_a_disc_twice_as_far_away_counts_a_quarter_as_by_chance_four_are_as_near() -> None:
    near, far = (company(disc(50.0, 40.0), [(disc(50.0, at), 3.0)]) for at in (4040.0, 8040.0))
    assert near / far == pytest.approx(4.0, rel=0.02)


@pytest.mark.parametrize(
    ("other", "odds"),
    [
        (disc(50.0, 120.0, 30.0), 3.0),
        (disc(50.0, 120.0), 0.5),
        (disc(50.0, 55.0), 3.0),
    ],
    ids=["another size", "doubtful itself", "the same thing"],
)
def test_what_is_no_sure_disc_of_its_size_beside_it_is_no_company(other: Disc, odds: float) -> None:
    assert company(disc(50.0, 40.0), [(other, odds)]) == 0.0


@pytest.mark.parametrize(("apart", "seen"), [(80.0, True), (560.0, False)])
def test_a_faint_disc_is_found_beside_one_like_it_and_not_across_the_picture(
    apart: float, seen: bool
) -> None:
    rng = np.random.default_rng(18)
    grain = np.asarray(cv2.GaussianBlur(rng.normal(0.0, 1.0, (120, 660)), (0, 0), 3.0))
    picture = 100.0 + 16.0 * grain / grain.std()
    for place, change in (((60.3, 610.8 - apart), 70.0), ((60.3, 610.8), 30.0)):
        cover = cv2.GaussianBlur(drawings.coverage((*place, 20.0), (120, 660)), (0, 0), 0.6)
        picture = picture + change * np.asarray(cover)
    found = find_balls(drawings.grey(picture, noise=2.0), (8.0, 40.0))
    assert any(math.hypot(each.row - 60.3, each.column - 610.8) < 2.0 for each in found) == seen


@pytest.mark.parametrize(("odds", "found"), [(2.0, 2), (-math.inf, 1), (-1.0, 0)])
def test_a_doubtful_disc_counts_unless_a_surer_circle_of_the_picture_is_no_ball(
    monkeypatch: pytest.MonkeyPatch, odds: float, found: int
) -> None:
    # The larger circle is surer, and judged first: it is a ball, a ring, or nothing round at all.
    def log_odds(values: object, each: Disc, *others: object) -> float:
        return 0.3 if each.radius < 20.0 else odds

    monkeypatch.setattr(finding, "log_odds", log_odds)
    picture = np.full((120, 220), 90.0)
    for place in ((60.3, 50.2, 30.0), (58.7, 160.4, 12.0)):
        picture += 80.0 * np.asarray(drawings.coverage(place, picture.shape))
    assert len(find_balls(drawings.grey(picture, noise=2.0), (8.0, 40.0))) == found
