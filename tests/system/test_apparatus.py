"""Each apparatus of the thesis fires on the simulators and is measured as its world was."""

from __future__ import annotations

import json
import math
import threading
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from rigctl import cli
from rigctl.config import StoreSection, load
from rigctl.daemon import open_daemon
from rigctl.firing import fire_and_wait
from rigctl.local import LocalRig
from rigctl.settings import ShotSettings
from simulators.laboratory import Laboratory
from tests.simulated import patient_text
from tests.system.real_rig import until

CONFIG = Path(__file__).parents[2] / "config"
SIGMAS = 4.0

Json = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Fired:
    """What a command printed, and what the world knows."""

    printed: Json
    truth: Json

    @property
    def result(self) -> Json:
        found = self.printed["result"]
        assert found["status"] == "measured", found
        return found


def with_store(name: str, folder: Path) -> Path:
    """Write a configuration whose store lies in a folder of the test; return its file."""
    text = patient_text((CONFIG / f"{name}.toml").read_text(encoding="utf-8"))
    before, _, after = text.partition('folder = "data')
    config = folder / "rig.toml"
    rest = after.partition('"')[2]
    config.write_text(f'{before}folder = "{folder}/data"{rest}', encoding="utf-8")
    return config


def fired(name: str, folder: Path, capsys: pytest.CaptureFixture[str], *settings: str) -> Fired:
    """Fire one shot of a configuration by the command, its store in a folder of the test."""
    config = str(with_store(name, folder))
    arguments = ["shot", "--local", "--json", "--wait-s", "600", "--config", config]
    assert cli.run([*arguments, *settings]) == 0
    printed = json.loads(capsys.readouterr().out)
    return Fired(printed, truths(folder)[-1])


def truths(folder: Path) -> list[Json]:
    """Return what the world wrote down of each shot."""
    lines = (folder / "data/laboratory/truth/truth.jsonl").read_text(encoding="utf-8")
    return [json.loads(line) for line in lines.splitlines()]


def off(quantity: Json, truth: float) -> float:
    """Return by how many of its standard errors a quantity differs from the truth."""
    return abs(quantity["value"] - truth) / quantity["sigma"]


def ratios(truth: Json) -> tuple[float, float]:
    return -truth["v_n_after"] / truth["v_n"], -truth["v_s_after"] / truth["v_s"]


NO_PUSHERS = ("--pressure-kpa", "0", "--offset-mm", "0")


@pytest.mark.long
@pytest.mark.timeout(900)
def test_spheres_of_half_an_inch_on_the_moon_are_measured_in_the_same_view(tmp_path: Path) -> None:
    # Twenty pixels wide, their markers three, and they fly half a radius from frame to frame.
    usual = load(CONFIG / "simulated.toml")
    half = usual.model_copy(
        update={
            "spheres": tuple(replace(each, diameter_m=0.0127) for each in usual.spheres),
            "environment": replace(usual.environment, gravity_m_per_s2=1.62),
            "store": StoreSection(folder=str(tmp_path / "data")),
            "camera": usual.camera.model_copy(update={"collect_timeout_s": 120.0}),
        }
    )
    with open_daemon(half) as daemon:
        rig = LocalRig(daemon, "a test")
        for pressure, offset in ((30.0, 1.5), (45.0, 3.7), (60.0, 2.6)):
            wanted = ShotSettings(
                pressure_a_kpa=pressure, pressure_b_kpa=pressure, offset_mm=offset
            )
            shot = fire_and_wait(rig, wanted, None, 600.0, lambda _: None)
            found, truth = shot["result"], truths(tmp_path)[-1]
            assert found["status"] == "measured", found
            e, beta = ratios(truth)
            assert off(found["e"], e) < SIGMAS
            assert off(found["beta"], beta) < SIGMAS
            assert off(found["v_n"], truth["v_n"]) < SIGMAS
            assert found["e"]["sigma"] < 0.005


@pytest.mark.long
@pytest.mark.timeout(600)
def test_solenoids_let_go_and_the_spheres_of_both_tubes_are_measured(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    angles = ("--angle-a-deg", "30", "--angle-b-deg", "30")
    shot = fired("simulated-release", tmp_path, capsys, *NO_PUSHERS, *angles)
    # A command takes 40 bits at 9600 baud: the second solenoid lets go that much later.
    assert shot.truth["fire_b_s"] - shot.truth["fire_a_s"] >= 40 / 9600 - 1e-9
    e, beta = ratios(shot.truth)
    assert off(shot.result["e"], e) < SIGMAS
    assert off(shot.result["beta"], beta) < SIGMAS
    assert off(shot.result["v_n"], shot.truth["v_n"]) < SIGMAS


@pytest.mark.long
@pytest.mark.timeout(600)
def test_spheres_of_two_millimetres_are_measured_through_the_lens(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings = ("--pressure-kpa", "22", "--offset-mm", "1.2")
    shot = fired("simulated-small", tmp_path, capsys, *settings)
    e, beta = ratios(shot.truth)
    assert off(shot.result["e"], e) < SIGMAS
    assert off(shot.result["beta"], beta) < SIGMAS
    assert off(shot.result["v_n"], shot.truth["v_n"]) < SIGMAS
    # Not known to the analysis before: less than a tenth of what spheres of an inch take.
    assert shot.truth["contact_duration_s"] < 2.5e-5


@pytest.mark.long
@pytest.mark.timeout(600)
def test_a_split_format_shows_the_collision_and_what_depth_hides_is_among_the_errors(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings = ("--pressure-kpa", "50", "--offset-mm", "8")
    shot = fired("simulated-split", tmp_path, capsys, *settings)
    assert shot.result["frame_rate_hz"] == 2000.0
    e, beta = ratios(shot.truth)
    assert off(shot.result["e"], e) < SIGMAS
    assert off(shot.result["beta"], beta) < SIGMAS
    assert shot.result["beta"]["sigma"] < 0.1


@pytest.mark.long
@pytest.mark.timeout(600)
def test_a_sphere_that_a_magnet_drops_on_a_plate_gives_one_impact_for_each_bounce(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shot = fired("simulated-plate", tmp_path, capsys, *NO_PUSHERS)
    impacts, truths = shot.result["impacts"], shot.truth["impacts"]
    assert len(impacts) == 3
    for found, truth in zip(impacts, truths, strict=False):
        assert off(found["e"], -truth["v_n_after"] / truth["v_n"]) < SIGMAS
        assert off(found["v_n"], truth["v_n"]) < SIGMAS
        assert found["v_s"]["value"] is None
        since = found["contact_time_s"] - impacts[0]["contact_time_s"]
        true_since = truth["contact_time_s"] - truths[0]["contact_time_s"]
        assert since == pytest.approx(true_since, abs=1e-4)


def test_a_power_cut_drops_both_spheres_and_none_falls_a_second_time(tmp_path: Path) -> None:
    configuration = load(CONFIG / "simulated-release.toml")
    store = StoreSection(folder=str(tmp_path / "data"))
    with open_daemon(configuration.model_copy(update={"store": store})) as daemon:
        settings = ShotSettings(
            pressure_a_kpa=0.0,
            pressure_b_kpa=0.0,
            offset_mm=0.0,
            angle_a_deg=30.0,
            angle_b_deg=30.0,
        )
        armed = daemon.rig.arm(settings, "anna")
        assert "lets the spheres go" in armed.warnings[0]
        assert isinstance(daemon.laboratory, Laboratory)
        assert daemon.laboratory.fires == 0
        daemon.rig.estop("anna", "a hand in the way")
        await_fires(daemon.laboratory, 1)
        daemon.rig.estop("anna", "once more")
    fires = (tmp_path / "data/laboratory/truth/fires.jsonl").read_text(encoding="utf-8")
    (fire,) = [json.loads(line) for line in fires.splitlines()]
    assert fire["fire_a_s"] == fire["fire_b_s"]


@pytest.mark.parametrize("angle_deg", [25.0, 45.0])
def test_the_simulated_tubes_stand_at_the_angles_that_a_shot_states(
    tmp_path: Path, angle_deg: float
) -> None:
    configuration = load(CONFIG / "simulated-release.toml")
    store = StoreSection(folder=str(tmp_path / "data"))
    with open_daemon(configuration.model_copy(update={"store": store})) as daemon:
        settings = ShotSettings(
            pressure_a_kpa=0.0,
            pressure_b_kpa=0.0,
            offset_mm=0.0,
            angle_a_deg=angle_deg,
            angle_b_deg=angle_deg,
        )
        daemon.rig.arm(settings, "anna")
        assert isinstance(daemon.laboratory, Laboratory)
        daemon.rig.estop("anna", "lets both go")
        await_fires(daemon.laboratory, 1)
        written = tmp_path / "data/laboratory/truth/truth.jsonl"
        # The world works a shot out in its own time.
        until(lambda: written.exists() and written.read_text(encoding="utf-8").endswith("\n"))
    truth = json.loads(written.read_text(encoding="utf-8"))
    # Rolling spheres leave with 10/7 g L sin(angle); the speeds of two tubes scatter by 0.4 %.
    tilt = math.radians(angle_deg)
    leaves = math.sqrt(2 * 9.80665 * 0.2 * math.sin(tilt) / 1.4)
    assert -truth["v_n"] == pytest.approx(2 * leaves * math.cos(tilt), rel=0.02)


def await_fires(laboratory: Laboratory, count: int) -> None:
    """Wait until the world has seen so many launches, ten seconds at most."""
    ended = threading.Event()
    for _ in range(1000):
        if laboratory.fires == count:
            return
        ended.wait(0.01)
    raise AssertionError(f"{laboratory.fires} launches, {count} were awaited")


def qualified(run: str, config: Path, capsys: pytest.CaptureFixture[str], *more: str) -> Json:
    assert cli.run(["qualify", run, "--config", str(config), "--json", *more]) == 0
    found: Json = json.loads(capsys.readouterr().out)
    return found


@pytest.mark.timeout(600)
def test_the_disk_is_recorded_and_turns_as_its_meter_says(
    capsys: pytest.CaptureFixture[str],
) -> None:
    found = qualified("disk", CONFIG / "simulated-disk.toml", capsys, "--method", "thesis")
    turns = found["methods"]["thesis"]
    pairs = [turn["pairs"] for turn in turns]
    # A recorder that a busy host stops late has more frames than the fifteen asked for.
    assert pairs[0] >= 14
    assert pairs == list(range(pairs[0], pairs[0] - 7, -1))
    assert all(abs(turn["relative_error"]) < 1e-3 for turn in turns)


@pytest.mark.long
@pytest.mark.timeout(600)
def test_the_slide_moves_the_sphere_step_by_step_and_each_place_is_found(
    capsys: pytest.CaptureFixture[str],
) -> None:
    found = qualified("stage", CONFIG / "simulated-stage.toml", capsys, "--method", "photometric")
    (error,) = found["errors"]
    assert error["largest_px"] < 0.02


@pytest.mark.long
@pytest.mark.timeout(600)
def test_a_magnet_drops_a_steel_sphere_again_and_again_and_gravity_is_that_of_the_place(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = with_store("simulated-drop", tmp_path)
    found = qualified("drop", config, capsys, "--method", "photometric", "--drops", "2")
    own = found["methods"]["photometric"]
    assert len(own["values_m_per_s2"]) == 2
    assert own["mean_m_per_s2"] == pytest.approx(9.80236, rel=2e-3)
