"""The first apparatus of the thesis: solenoids that hold, tubes turned by hand, no pressure."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from rig_fakes import Laboratory

from rigctl.config import load
from rigctl.errors import SettingsError
from rigctl.settings import ShotSettings

RELEASE = Path(__file__).parents[3] / "config" / "release.toml"
TILTED = ShotSettings(
    pressure_a_kpa=0.0, pressure_b_kpa=0.0, offset_mm=0.0, angle_a_deg=30.0, angle_b_deg=40.0
)


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Laboratory]:
    laboratory = Laboratory(tmp_path / "data", configuration=load(RELEASE))
    yield laboratory
    laboratory.close()


def test_it_fires_without_regulator_and_slide(lab: Laboratory) -> None:
    shot = lab.fire(lab.rig.arm(TILTED, "anna").token)
    assert (shot.state, shot.simulated) == ("stored", False)
    assert lab.store.folders.manifest(shot.id)["settings"]["angle_b_deg"] == 40.0
    assert not any(call.startswith(("regulator", "slide")) for call in lab.log)


def test_arming_warns_that_a_power_cut_lets_the_spheres_go(lab: Laboratory) -> None:
    warnings = lab.rig.arm(TILTED, "anna").warnings
    assert "lets the spheres go" in warnings[0]
    assert lab.rig.status().warnings == warnings


def test_the_pusher_apparatus_warns_of_nothing(tmp_path: Path) -> None:
    lab = Laboratory(tmp_path / "data")
    assert lab.rig.status().warnings == ()
    lab.close()


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"angle_a_deg": None}, "angle_a_deg"),
        ({"angle_b_deg": 85.0}, "angle_b_deg"),
        ({"pressure_a_kpa": 1.0}, "pressure_a_kpa"),
        ({"offset_mm": 1.0}, "offset_mm"),
    ],
)
def test_settings_of_the_other_apparatus_are_refused(
    lab: Laboratory, changes: dict[str, float | None], field: str
) -> None:
    with pytest.raises(SettingsError, match=field):
        lab.rig.arm(TILTED.model_copy(update=changes), "anna")


def test_closing_leaves_the_power_because_a_cut_would_let_the_spheres_go(lab: Laboratory) -> None:
    lab.log.clear()
    lab.rig.close()
    assert "cut_off.cut" not in lab.log
    assert "trigger.make_safe" in lab.log
