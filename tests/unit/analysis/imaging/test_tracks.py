import numpy as np
import pytest

from analysis.imaging.outlines import Outline
from analysis.imaging.shells import Circle
from analysis.imaging.tracks import MOST_MISSES, Track, frames_of
from analysis.imaging.views import View


def outline(row: float, column: float) -> Outline:
    return Outline(Circle(row, column, 20.0, np.zeros((3, 3))), 1.0, np.zeros((0, 2)))


def track(places: dict[int, tuple[float, float]]) -> Track:
    return Track(View.FRONT, {k: outline(*place) for k, place in places.items()})


@pytest.mark.parametrize(
    ("places", "frame", "direction", "expected"),
    [
        ({4: (10.0, 20.0)}, 5, 1, (10.0, 20.0)),
        ({3: (9.0, 17.0), 4: (10.0, 20.0)}, 5, 1, (11.0, 23.0)),
        ({3: (9.0, 17.0), 4: (10.0, 20.0)}, 6, 1, (12.0, 26.0)),
        ({2: (8.0, 14.0), 4: (10.0, 20.0)}, 5, 1, (11.0, 23.0)),
        ({4: (10.0, 20.0), 5: (11.0, 23.0)}, 3, -1, (9.0, 17.0)),
        ({1: (0.0, 0.0), 3: (9.0, 17.0), 4: (10.0, 20.0), 9: (5.0, 5.0)}, 5, 1, (11.0, 23.0)),
    ],
)
def test_a_centre_is_carried_on_along_its_last_two_frames(
    places: dict[int, tuple[float, float]],
    frame: int,
    direction: int,
    expected: tuple[float, float],
) -> None:
    assert track(places).predict(frame, direction) == pytest.approx(expected)


def test_a_sphere_out_of_sight_for_too_long_is_lost() -> None:
    seen = track({0: (10.0, 10.0), 1: (11.0, 12.0)})
    assert seen.predict(1 + MOST_MISSES + 1, 1) is not None
    assert seen.predict(1 + MOST_MISSES + 2, 1) is None
    assert seen.predict(0, -1) is not None
    assert track({}).predict(3, 1) is None


def test_a_frame_without_outline_has_no_centre() -> None:
    seen = track({2: (10.0, 12.0)})
    assert seen.centre(2) == (10.0, 12.0)
    assert seen.centre(3) is None


def test_the_frames_are_those_that_show_any_disc() -> None:
    a, b = track({4: (1.0, 2.0), 1: (3.0, 4.0)}), track({0: (5.0, 6.0), 1: (0.0, 0.0)})
    assert frames_of(({View.FRONT: a}, {View.FRONT: b})) == [0, 1, 4]
    assert frames_of(({}, {})) == []
