"""Poses of a ball that meets a wall, a slope or a ceiling: where it lies, and what its law is."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from analysis.effects.contact.plate_tilt import leaning, tangents
from analysis.errors import InputError
from analysis.exchange.pose_table import read_poses
from analysis.model.data.gather import gather
from analysis.model.data.plate import Plate, bounces_of
from analysis.model.data.poses import PoseData
from analysis.model.data.reading import stream_poses
from rigctl import cli
from simulators.challenge.drops import Drop
from tests.unit.analysis.model.dropped import write_drops


class Meeting(NamedTuple):
    """Into what a ball flies, how far it is at first, m, and how fast it comes and drifts, m/s."""

    into: tuple[float, float, float]
    away_m: float
    toward: tuple[float, float]
    sideways: float = 0.5


WALL = Meeting((0.0, 1.0, 0.0), 0.05, (0.5, 3.0))
SLOPE = Meeting((0.8, 0.3, 0.52), 0.1, (0.0, 1.0))
CEILING = Meeting((-1.0, 0.0, 0.0), 0.05, (2.5, 4.0), 1.2)


def thrown(
    folder: Path, meeting: Meeting, *, friction: float = 0.15, plate: str = "", shots: int = 8
) -> Path:
    return write_drops(
        folder,
        Drop(drag_coefficient=0.45, friction=friction, into=meeting.into, tilt=(0.0, 0.003)),
        shots=shots,
        seed=3,
        sigma_m=2e-5,
        sideways=meeting.sideways,
        lasts_s=0.25,
        heights_m=(meeting.away_m / 3, meeting.away_m),
        toward=meeting.toward,
        plate=plate,
    )


def true_normal(meeting: Meeting) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return Drop(into=meeting.into, tilt=(0.0, 0.003)).normal


def posed(folder: Path) -> PoseData:
    data = gather(folder)[1]
    assert isinstance(data, PoseData)
    return data


@pytest.mark.parametrize(
    ("meeting", "friction"),
    [
        (WALL, 0.1),
        (SLOPE, 0.4),
        (CEILING, 0.1),
        pytest.param(WALL, 0.4, marks=pytest.mark.long),
        pytest.param(SLOPE, 0.1, marks=pytest.mark.long),
        pytest.param(CEILING, 0.4, marks=pytest.mark.long),
    ],
)
def test_a_plate_that_nobody_described_is_found_within_its_error(
    meeting: Meeting, friction: float, tmp_path: Path
) -> None:
    plate = posed(thrown(tmp_path, meeting, friction=friction)).plate
    off = np.arccos(min(1.0, float(np.array(plate.normal) @ true_normal(meeting))))
    assert off < 3 * plate.sigma_rad
    assert plate.sigma_rad < 0.03


def test_friction_makes_no_slope_of_a_level_plate(tmp_path: Path) -> None:
    level = Meeting((1.0, 0.0, 0.0), 0.3, (0.0, 0.0))
    assert posed(thrown(tmp_path, level, friction=0.4)).plate == Plate()


@pytest.mark.parametrize(
    ("meeting", "plate"),
    [
        (WALL, "normal = [0.0, 2.0, 0.0]"),
        pytest.param(SLOPE, "", marks=pytest.mark.long),
        pytest.param(CEILING, "", marks=pytest.mark.long),
    ],
)
def test_fit_gives_the_law_and_the_lean_of_any_plate(
    meeting: Meeting, plate: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = thrown(tmp_path, meeting, plate=plate)
    assert cli.run(["model", "fit", str(folder), "--with", "lasting-contact", "--json"]) == 0
    fit = json.loads(capsys.readouterr().out)
    assert fit["chi2_per_dof"] == pytest.approx(1.0, abs=0.1)
    found = {**fit["parameters"], **{one["nuisance"]: one["found"] for one in fit["nuisances"]}}
    truth = {"mu": 0.15, "lasting-contact.kappa": 0.3, "lasting-contact.zeta": 0.05}
    for name, value in truth.items():
        assert abs(found[name]["value"] - value) < 4 * found[name]["sigma"] + 1e-3, name
    tilt = [found[f"plate-tilt.{axis}"]["value"] for axis in "yz"]
    normal = leaning(np.array([posed(folder).plate.normal]), np.array(tilt))[0]
    assert np.arccos(min(1.0, float(normal @ true_normal(meeting)))) < 1e-3


def test_a_throw_that_does_not_reach_the_ceiling_is_no_bounce(tmp_path: Path) -> None:
    folder = thrown(tmp_path, CEILING._replace(away_m=0.3, toward=(1.0, 1.2)))
    up = Plate((-1.0, 0.0, 0.0))
    for spheres in read_poses(folder / "poses.csv").values():
        assert bounces_of(spheres["a"], up) == []
    with pytest.raises(InputError, match="state its normal"):
        gather(folder)


def test_streamed_poses_of_a_wall_are_those_of_memory(tmp_path: Path) -> None:
    folder = thrown(tmp_path, WALL)
    memory, stream = posed(folder), stream_poses(folder)[1].whole()
    assert memory.plate == stream.plate
    assert np.array_equal(memory.shots, stream.shots)
    assert np.array_equal(memory.position, stream.position)


@pytest.mark.parametrize("normal", ["[0, 0, 0]", "[1.0, 0.0]", '"down"'])
def test_a_normal_without_a_direction_is_refused_by_its_name(normal: str, tmp_path: Path) -> None:
    folder = thrown(tmp_path, WALL, shots=1, plate=f"normal = {normal}")
    with pytest.raises(InputError, match="normal"):
        gather(folder)


def test_a_plate_leans_along_two_directions_in_its_plane() -> None:
    normals = np.random.default_rng(4).normal(size=(200, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    one, other = tangents(normals)
    frame = np.stack([normals, one, other], axis=2)
    assert np.allclose(np.swapaxes(frame, 1, 2) @ frame, np.eye(3), atol=1e-12)
