import numpy as np
import pytest
from drawings import SETTINGS, THRESHOLD, Place, draw, grey

from analysis.errors import ShotRefusedError
from analysis.imaging.assignment import follow, seed_frame
from analysis.imaging.edge.frame import FilmEdges
from analysis.imaging.film_discs import FilmDiscs
from analysis.imaging.flight_hypotheses import Falling
from analysis.imaging.views import View, view_geometries
from analysis.setup import CameraSetup

SHAPE, RADIUS = (140, 160), 14.0
VIEWS = view_geometries(
    CameraSetup(1000.0, *SHAPE, front_view_rows=(60, 140), top_view_rows=(0, 60))
)
FALLING = Falling(np.arange(20) / 1000.0, 9.8e3)
SPHERES = ("a", "b")


def places(
    k: int, front_rows: tuple[float, float], climb: tuple[float, float] = (0.0, 0.0)
) -> dict[tuple[str, View], Place]:
    """Sphere a comes from the left, b from the right; they turn back at frame 6."""
    way = 3.0 * (6 - abs(k - 6))
    columns = {"a": 30.0 + way, "b": 130.0 - way}
    rows = {name: front_rows[i] + climb[i] * k for i, name in enumerate(SPHERES)}
    tops = {"a": 26.0, "b": 29.0}
    return {
        (name, view): (
            rows[name] if view is View.FRONT else tops[name],
            columns[name] + 0.31 * k,
            RADIUS,
        )
        for name in SPHERES
        for view in View
    }


def film(truth: list[dict[tuple[str, View], Place]], hidden: tuple[str, ...] = ()) -> FilmEdges:
    return filmed(shown(truth, hidden))


def shown(truth: list[dict[tuple[str, View], Place]], hidden: tuple[str, ...]) -> list[np.ndarray]:
    visible = [[place for (name, _), place in t.items() if name not in hidden] for t in truth]
    return [draw(discs, SHAPE) for discs in visible]


def filmed(drawings: list[np.ndarray]) -> FilmEdges:
    frames = [grey(drawing, noise=1.0, seed=k) for k, drawing in enumerate(drawings)]
    return FilmEdges(np.array(frames), SETTINGS, THRESHOLD)


def assert_followed(discs: FilmDiscs, truth: list[dict[tuple[str, View], Place]]) -> None:
    for name, sphere in zip(SPHERES, discs.tracks(), strict=True):
        for view in View:
            for k, expected in enumerate(truth):
                centre = sphere[view].centre(k)
                assert centre is not None, (name, view, k)
                assert centre == pytest.approx(expected[name, view][:2], abs=0.1)


def test_both_spheres_are_followed_in_both_views_through_all_frames() -> None:
    truth = [places(k, (95.0, 110.0)) for k in range(13)]
    assert_followed(follow(film(truth), VIEWS, (RADIUS, RADIUS), FALLING)[0], truth)


def test_a_sphere_that_crosses_into_the_rows_of_the_other_view_keeps_its_name() -> None:
    truth = [places(k, (95.0, 118.0), climb=(-3.2, 0.0)) for k in range(13)]
    # It ends above row 60, where the top view's rows begin.
    assert truth[-1]["a", View.FRONT][0] < 60.0
    moved = [
        {key: (row - 8 if key[1] is View.TOP else row, c, r) for key, (row, c, r) in t.items()}
        for t in truth
    ]
    assert_followed(follow(film(moved), VIEWS, (RADIUS, RADIUS), FALLING)[0], moved)


def passing(k: int) -> dict[tuple[str, View], Place]:
    """Spheres that fly past each other, one well above the other in both views."""
    columns = {"a": 60.0 + 4.0 * k, "b": 104.0 - 4.0 * k}
    rows = {"a": {View.FRONT: 80.0, View.TOP: 15.0}, "b": {View.FRONT: 120.0, View.TOP: 45.0}}
    return {
        (name, view): (rows[name][view], columns[name], RADIUS) for name in SPHERES for view in View
    }


def test_a_is_the_sphere_that_comes_from_the_left_even_where_it_ends_on_the_right() -> None:
    truth = [passing(k) for k in range(13)]
    assert truth[-1]["a", View.FRONT][1] > truth[-1]["b", View.FRONT][1]
    assert_followed(follow(film(truth), VIEWS, (RADIUS, RADIUS), FALLING)[0], truth)


def test_the_seed_is_the_frame_that_shows_both_spheres_in_both_views() -> None:
    truth = [places(k, (95.0, 110.0)) for k in range(5)]
    drawings = shown(truth[:2], ("b",)) + shown(truth[2:3], ()) + shown(truth[3:], ("a",))
    seed, pairs = seed_frame(filmed(drawings), VIEWS, (RADIUS, RADIUS))
    assert seed == 2
    for view in View:
        for disc, name in zip(pairs[view], SPHERES, strict=True):
            assert (disc.row, disc.column) == pytest.approx(truth[2][name, view][:2], abs=1.0)


def test_one_sphere_alone_is_refused_with_what_was_seen() -> None:
    truth = [places(k, (95.0, 110.0)) for k in range(4)]
    with pytest.raises(ShotRefusedError) as refusal:
        follow(film(truth, hidden=("b",)), VIEWS, (RADIUS, RADIUS), FALLING)
    assert refusal.value.step == "assignment"
    assert refusal.value.frame in range(4)
    assert "of 2 in the top view, as discs of radius 14.0 px" in refusal.value.reason
    row, column, _ = truth[refusal.value.frame or 0]["a", View.FRONT]
    assert any(abs(r - row) < 1 and abs(c - column) < 1 for r, c, _ in refusal.value.discs)


def test_blank_frames_are_refused_with_no_disc_seen() -> None:
    blank = FilmEdges(np.full((3, *SHAPE), 40, dtype=np.uint8), SETTINGS, THRESHOLD)
    with pytest.raises(ShotRefusedError, match=r"assignment.* shows 0 of 2 in the front view"):
        follow(blank, VIEWS, (RADIUS, RADIUS), FALLING)


def test_views_whose_columns_disagree_do_not_show_the_same_spheres() -> None:
    apart = places(0, (95.0, 110.0))
    apart = {
        (name, view): (row, column + (25.0 if view is View.TOP else 0.0), r)
        for (name, view), (row, column, r) in apart.items()
        if (name, view) != ("b", View.TOP)
    }
    apart["b", View.TOP] = (26.0, 100.0, RADIUS)
    with pytest.raises(ShotRefusedError, match="columns of the views in agreement"):
        seed_frame(film([apart]), VIEWS, (RADIUS, RADIUS))
