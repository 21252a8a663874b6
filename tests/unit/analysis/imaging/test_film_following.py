import numpy as np
import pytest

from analysis.imaging.film_following import MOST_MISSES, predict

Place = tuple[float, float]


def predicted(places: dict[int, Place], frame: int, direction: int) -> Place | None:
    circles, coverage = np.zeros((20, 3)), np.full(20, -1.0)
    for k, place in places.items():
        circles[k, :2], coverage[k] = place, 1.0
    found = np.zeros(3)
    known = predict(circles, coverage, frame, direction, found)
    return (float(found[0]), float(found[1])) if known else None


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
    places: dict[int, Place], frame: int, direction: int, expected: Place
) -> None:
    assert predicted(places, frame, direction) == pytest.approx(expected)


def test_a_sphere_out_of_sight_for_too_long_is_lost() -> None:
    seen = {0: (10.0, 10.0), 1: (11.0, 12.0)}
    assert predicted(seen, 1 + MOST_MISSES + 1, 1) is not None
    assert predicted(seen, 1 + MOST_MISSES + 2, 1) is None
    assert predicted({}, 3, 1) is None
