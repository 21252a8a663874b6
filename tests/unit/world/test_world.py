import json
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from simulators.world import Launch, World, WorldDescription, render_shot
from simulators.world.description import ContactLaw

LAUNCH = Launch(45.0, 45.0, 0.008, 100.0, 100.0)


@pytest.fixture
def world(tmp_path: Path) -> World:
    return World(WorldDescription(), 7, tmp_path / "truth")


def lines(world: World, name: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (world.truth_folder / name).read_text().splitlines()]


def brightest(world: World, time_s: float) -> int:
    return int(world.picture(time_s).max())


def test_an_empty_world_shows_only_its_background(world: World) -> None:
    assert world.picture(3.0).shape == (192, 240)
    assert brightest(world, 3.0) < 60


def test_a_fire_puts_spheres_in_the_field_and_they_leave_it_again(world: World) -> None:
    assert world.fire(LAUNCH) == 1
    assert brightest(world, 99.999) < 60
    assert brightest(world, 100.0005) < 60
    assert brightest(world, 100.045) > 100
    assert brightest(world, 100.5) < 60


def test_the_same_picture_is_the_same_to_the_last_bit(world: World) -> None:
    world.fire(LAUNCH)
    np.testing.assert_array_equal(world.picture(100.04), world.picture(100.04))


def test_pictures_at_other_times_have_other_noise(world: World) -> None:
    assert np.any(world.picture(1.0) != world.picture(1.001))


def test_the_same_seed_makes_the_same_world(tmp_path: Path) -> None:
    pictures = []
    for name in ("one", "other"):
        world = World(WorldDescription(), 7, tmp_path / name)
        world.fire(LAUNCH)
        pictures.append(world.picture(100.04))
    np.testing.assert_array_equal(*pictures)


def test_shots_of_one_world_scatter(world: World) -> None:
    for start in (100.0, 102.0):
        world.fire(Launch(45.0, 45.0, 0.008, start, start))
        world.picture(start + 0.04)
    first, second = lines(world, "truth.jsonl")
    assert first["v_n"] != second["v_n"]
    assert first["v_n"] == pytest.approx(second["v_n"], rel=0.1)


def test_each_fire_is_counted_on_disk_before_it_returns(world: World) -> None:
    for count in range(1, 4):
        world.fire(Launch(45.0, 45.0, 0.008, 100.0 + count, 100.0 + count))
        assert world.fires == count
        assert [line["shot"] for line in lines(world, "fires.jsonl")] == list(range(1, count + 1))


def test_fires_from_many_threads_are_all_counted_once(world: World) -> None:
    start = threading.Barrier(6)

    def pull() -> None:
        start.wait(10.0)
        world.fire(Launch(5.0, 5.0, 0.0, 1.0, 1.0))

    threads = [threading.Thread(target=pull) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(10.0)
    assert world.fires == 6
    assert sorted(line["shot"] for line in lines(world, "fires.jsonl")) == list(range(1, 7))


def test_the_truth_agrees_with_the_velocities_it_states(world: World) -> None:
    world.fire(LAUNCH)
    world.picture(100.04)
    (truth,) = lines(world, "truth.jsonl")
    normal = np.array(truth["normal"])
    radius = 0.0127
    for when, v_n in (("before", truth["v_n"]), ("after", truth["v_n_after"])):
        a, b = (np.array(v) for v in truth[f"velocity_{when}"])
        assert v_n == pytest.approx((b - a) @ normal)
    a, b = (np.array(v) for v in truth["velocity_before"])
    spin = sum(np.array(w) for w in truth["spin_before"])
    surface = np.cross(normal, np.cross(b - a - radius * np.cross(spin, normal), normal))
    assert truth["v_s"] == pytest.approx(np.linalg.norm(surface))
    centre_a, centre_b = (np.array(c) for c in truth["centre_at_contact"])
    assert np.linalg.norm(centre_b - centre_a) == pytest.approx(2.0 * radius, abs=1e-9)
    np.testing.assert_allclose((centre_b - centre_a) / (2.0 * radius), normal, atol=1e-7)
    assert truth["v_n"] < 0.0 < truth["v_n_after"]
    assert not truth["missed"]


def test_spheres_that_pass_each_other_are_a_missed_shot(world: World) -> None:
    world.fire(Launch(45.0, 45.0, 0.030, 100.0, 100.0))
    assert brightest(world, 100.045) > 100
    (truth,) = lines(world, "truth.jsonl")
    assert truth["missed"]
    assert "v_n" not in truth


def test_a_shot_that_cannot_be_worked_out_is_told_to_whoever_looks(tmp_path: Path) -> None:
    impossible = WorldDescription(contact=ContactLaw(restitution=2.0))
    world = World(impossible, 1, tmp_path)
    world.fire(LAUNCH)
    with pytest.raises(ValueError, match="restitution must lie in"):
        world.picture(100.04)


def test_a_rendered_shot_shows_the_spheres_where_its_truth_says() -> None:
    shot = render_shot(WorldDescription(), LAUNCH, 5, frames=12)
    assert shot.frames.shape == (12, 192, 240)
    assert 0.0 < shot.truth["contact_time_s"] < shot.times_s[-1]
    middle = shot.truth["contact_time_s"]
    last = int(np.searchsorted(shot.times_s, middle)) - 1
    a, b = (np.array(centre) for centre in shot.truth["centres_front_px"][last])
    # Just before the touch the discs are a diameter apart, less what is hidden along Z.
    gap = np.hypot(*(b - a)) - 40.0
    closing_px = 2.0 * 3.0 * 1574.8 * 1e-3
    assert -0.1 < gap < closing_px
    frame = shot.frames[last].astype(float)
    for row, column in (a, b):
        patch = frame[round(row) - 10 : round(row) + 11, round(column) - 10 : round(column) + 11]
        assert np.median(patch) > 100.0


def test_split_pictures_of_the_world_are_the_middle_of_the_frame(world: World) -> None:
    assert world.picture(2.0, 48).shape == (48, 240)
    with pytest.raises(ValueError, match="rows"):
        world.picture(2.0, 100)
