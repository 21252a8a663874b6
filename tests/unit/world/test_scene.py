"""A configuration changes the simulated world: what it states of spheres and surroundings is so."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from simulators.laboratory import open_laboratory
from simulators.world import Launch, World
from simulators.world.render import Camera
from simulators.world.scene import described
from simulators.world.state import Pose

HALF_INCH = {"diameter_m": 0.0127, "density_kg_per_m3": 2700.0, "inertia_factor": 0.4}
MOON = {"gravity_m_per_s2": 1.62, "air_density_kg_per_m3": 0.0}


def test_without_a_word_the_world_is_the_nylon_rigs() -> None:
    world = described({})
    assert world.sphere_a.diameter_m == 0.0254
    assert world.environment.gravity_m_per_s2 == 9.80665


def test_spheres_and_surroundings_are_those_of_the_configuration() -> None:
    world = described({"spheres": [HALF_INCH, HALF_INCH], "environment": MOON})
    # Mass of a ball of aluminium of half an inch: pi/6 d^3 rho.
    assert world.sphere_b.mass_kg == pytest.approx(2.896e-3, rel=1e-3)
    assert world.environment.gravity_m_per_s2 == 1.62
    assert world.environment.air_density_kg_per_m3 == 0.0


def test_a_configurations_drag_is_a_belief_and_the_worlds_is_its_own() -> None:
    scene = {"environment": {"drag_coefficient": 0.9}}
    assert described(scene).environment.drag_coefficient == 0.4
    assert described(scene, air={"drag_coefficient": 1.2}).environment.drag_coefficient == 1.2


@pytest.mark.parametrize(("pictures", "rows"), [(1, 192), (2, 96), (3, 64), (4, 48), (6, 32)])
def test_a_split_picture_shows_the_origin_where_the_configuration_aims_the_camera(
    pictures: int, rows: int
) -> None:
    optics = {"front_view_rows": [0, rows], "front_origin_px": [rows / 2 - 3.0, 117.0]}
    world = described({"rows": rows, "optics": optics | {"scale_px_per_m": 500.0}})
    sphere = world.sphere_a
    camera = Camera(world.optics, (sphere,), (np.empty((0, 3)),))
    at_origin = Pose(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))
    picture = camera.expose(lambda _: [at_origin], 0.0, rows)
    assert picture.shape == (rows, 240)
    bright = picture > 70.0
    seen_rows, seen_columns = np.nonzero(bright)
    assert seen_rows.mean() == pytest.approx(rows / 2 - 3.0, abs=0.3)
    assert seen_columns.mean() == pytest.approx(117.0, abs=0.3)
    assert bright.sum() == pytest.approx(np.pi * (0.0127 * 500.0) ** 2, rel=0.15)


def test_spheres_on_the_moon_fall_as_on_the_moon(tmp_path: Path) -> None:
    fallen, times = {}, {}
    for name, gravity in (("moon", 1.62), ("earth", 9.80665)):
        surroundings = {"gravity_m_per_s2": gravity, "air_density_kg_per_m3": 0.0}
        world = World(described({"environment": surroundings}), 5, tmp_path / name)
        world.fire(Launch(60.0, 60.0, 0.006, 1.0, 1.0))
        world.picture(1.2)  # waits until the shot is worked out
        [line] = (tmp_path / name / "truth.jsonl").read_text().splitlines()
        truth = json.loads(line)
        fallen[name] = truth["centre_at_contact"][0][0]
        times[name] = truth["contact_time_s"] - truth["fire_a_s"] % 1.0
    # From the tube's mouth on: some of the time passes in valve and tube.
    free_s = times["earth"] - 0.006
    assert fallen["earth"] - fallen["moon"] == pytest.approx(
        0.5 * (9.80665 - 1.62) * free_s**2, rel=0.3
    )


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"contact": {"friktion": 0.1}}, "contact.friktion"),
        ({"contact": {"restitution": 1.2}}, "contact.restitution"),
        ({"contact": {"friction": True}}, "contact.friction"),
        ({"tube": {"stroke_m": float("nan")}}, "tube.stroke_m"),
        ({"air": 3.0}, "simulation.air"),
        ({"scene": {"spheres": [HALF_INCH, {"name": "b", "plate": True}]}}, "plate"),
        ({"hides": "mass-mismatch", "contact": {"friction": 0.2}}, "hides"),
    ],
)
def test_what_the_world_cannot_be_is_refused_by_name(
    tmp_path: Path, options: dict[str, object], named: str
) -> None:
    with pytest.raises(ValueError, match=named.replace(".", r"\.")):
        open_laboratory(tmp_path, options)


def test_true_diameters_and_the_drag_are_off_by_their_stated_errors() -> None:
    stated = HALF_INCH | {"diameter_sigma_m": 1e-5}
    scene = {"spheres": [stated, stated]}
    off = []
    for seed in range(400):
        world = described(scene, rng=np.random.default_rng(seed))
        assert world.sphere_a.diameter_m == world.sphere_b.diameter_m
        drag = world.environment.drag_coefficient
        off.append(((world.sphere_a.diameter_m - 0.0127) / 1e-5, (drag - 0.40) / 0.02))
    assert np.mean(off, axis=0) == pytest.approx(0.0, abs=4 / np.sqrt(400))
    assert np.std(off, axis=0) == pytest.approx(1.0, abs=4 / np.sqrt(800))
    assert described(scene).sphere_a.diameter_m == 0.0127
