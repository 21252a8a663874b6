"""The recorder's keypad: over REST and by command, on the simulated tape and its real protocol."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import httpx
import numpy as np
import pytest

from rigctl.cameras.keypad import Keypad
from rigctl.config import StoreSection, load
from rigctl.daemon import Daemon, open_daemon
from rigctl.errors import (
    DeviceAnswerError,
    DeviceError,
    InterlockError,
    RefusedError,
    SettingsError,
)
from rigctl.settings import ShotSettings
from tests.system.real_rig import KEY, RealRig, real_rig, until

SETTINGS = ShotSettings(pressure_a_kpa=40.0, pressure_b_kpa=40.0, offset_mm=6.0)
PER_S = 1000


@pytest.fixture
def daemon(tmp_path: Path) -> Iterator[Daemon]:
    """A rig whose tape has room for one shot and no second."""
    configuration = load()
    # A busy host answers late, and nothing here is about that.
    patient = configuration.camera.recorder.model_copy(update={"answer_timeout_s": 10.0})
    changes = {
        "when_full": "ask",
        "start_timeout_s": 24.6,
        "collect_timeout_s": 90.0,
        "recorder": patient,
    }
    camera = configuration.camera.model_copy(update=changes)
    store = StoreSection(folder=str(tmp_path / "data"))
    changed = configuration.model_copy(update={"camera": camera, "store": store})
    with open_daemon(changed) as opened:
        yield opened


@pytest.fixture
def keypad(daemon: Daemon) -> Keypad:
    assert daemon.keypad is not None
    return daemon.keypad


def fire(daemon: Daemon) -> Any:
    token = daemon.rig.arm(SETTINGS, "anna").token
    return daemon.rig.fire(token, token, "body", actor="anna")


def record(keypad: Keypad, pictures: int) -> int:
    keypad.record()
    until(lambda: keypad.status().pictures >= pictures)
    keypad.stop()
    return keypad.status().pictures


def test_a_nearly_full_tape_refuses_to_arm_with_the_question_and_keeps_its_sessions(
    daemon: Daemon, keypad: Keypad
) -> None:
    record(keypad, 400)
    with pytest.raises(InterlockError) as refused:
        daemon.rig.arm(SETTINGS, "anna")
    (sentence,) = (each for each in refused.value.tripped if each.startswith("camera:"))
    assert "the tape has no room" in sentence
    assert "erase all its sessions?" in sentence
    assert "rigctl recorder erase" in sentence
    assert keypad.status().sessions.keys() == {1}


def test_a_tape_that_somebody_erased_takes_the_next_shot_without_a_restart(
    daemon: Daemon, keypad: Keypad
) -> None:
    record(keypad, 400)
    with pytest.raises(InterlockError):
        fire(daemon)
    keypad.erase()
    assert fire(daemon).outcome == "stored"


def test_where_the_operator_agreed_the_shot_erases_the_tape_and_its_manifest_says_so(
    daemon: Daemon, keypad: Keypad
) -> None:
    record(keypad, 400)
    keypad.agree(erases_when_full=True)
    shot = fire(daemon)
    assert shot.outcome == "stored"
    manifest = daemon.store.folders.manifest(shot.id)
    assert "sessions [1] were erased, as agreed" in manifest["recording"]["evidence"]


def test_playback_goes_forward_and_back_at_its_speeds_and_ends_where_the_tape_does(
    keypad: Keypad,
) -> None:
    pictures = record(keypad, 60)
    keypad.search(frame=10)
    until(lambda: keypad.status().mode == "STOP")
    assert keypad.status().picture == 10
    keypad.jog(-30)
    until(lambda: keypad.status().mode == "STOP")
    assert keypad.status().picture == 0
    keypad.jog(30)
    until(lambda: (keypad.status().picture or 0) >= 5)
    keypad.stop()
    stopped = keypad.status().picture
    keypad.step(-1)
    assert keypad.status().picture == stopped - 1
    keypad.search(frame=pictures - 2)
    keypad.play()
    until(lambda: keypad.status().mode == "STOP")
    assert keypad.status().picture == pictures - 1
    for speed in (0, 31, -31):
        with pytest.raises(SettingsError, match="1 to 30"):
            keypad.jog(speed)


def test_a_picture_is_found_by_session_frame_time_and_mark(daemon: Daemon, keypad: Keypad) -> None:
    shot = fire(daemon)
    (mark,) = keypad.status().marks
    keypad.erase()
    assert fire(daemon).outcome == shot.outcome == "stored"
    (mark,) = keypad.status().marks
    record(keypad, 30)
    keypad.search(session=1, mark=1)
    until(lambda: keypad.status().mode == "STOP")
    assert (keypad.status().session, keypad.status().picture) == (1, mark)
    keypad.search(time_s=0.02)
    until(lambda: keypad.status().mode == "STOP")
    assert (keypad.status().picture, keypad.status().picture_s) == (20, 20 / PER_S)
    keypad.search(session=2)
    assert (keypad.status().session, keypad.status().picture) == (2, 0)
    with pytest.raises(SettingsError, match="no such mark"):
        keypad.search(mark=1)
    with pytest.raises(DeviceAnswerError, match="RANGE"):
        keypad.search(session=3)


def test_gamma_lifts_the_greys_that_are_looked_at_by_its_power(keypad: Keypad) -> None:
    record(keypad, 20)
    keypad.search(frame=15)
    found = keypad.still()
    assert found.sequence.tolist() == [15]
    plain = found.pixels[0].astype(float)
    keypad.gamma(0.5)
    seen = keypad.still().pixels[0].astype(float)
    assert np.abs(seen - 255.0 * np.sqrt(plain / 255.0)).max() <= 0.5 + 1e-9
    assert seen.mean() > plain.mean()


def test_keys_are_refused_while_a_shot_is_recorded_and_the_shot_is_whole(
    daemon: Daemon, keypad: Keypad
) -> None:
    token = daemon.rig.arm(SETTINGS, "anna").token
    shot = daemon.rig.accept(token, token, "body", actor="anna")
    for _ in range(20):
        assert daemon.rig.status().running is not None
        with pytest.raises(RefusedError):
            keypad.stop()
    ended = daemon.rig.wait(shot.id)
    assert (ended.outcome, ended.lost) == ("stored", 0), ended.failure


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RealRig]:
    with real_rig(tmp_path_factory.mktemp("keypad")) as opened:
        opened.start()
        yield opened


def test_the_keypad_by_command_and_rest_and_an_erasure_stands_in_the_audit(rig: RealRig) -> None:
    def press(**order: Any) -> dict[str, Any]:
        answer = rig.ask("POST", "/rig/recorder", order)
        assert answer.status_code == 200, answer.text
        return dict(answer.json())

    assert press(key="record")["mode"] in {"STARTING", "RECORD"}
    until(lambda: rig.ask("GET", "/rig/recorder").json()["pictures"] > 50)
    press(key="stop")
    searched = rig.command("recorder", "search", "--frame", "20")
    assert searched.returncode == 0, searched.stderr
    until(lambda: rig.ask("GET", "/rig/recorder").json()["mode"] == "STOP")
    assert "picture 20, 0.0200 s" in rig.command("recorder").stdout
    picture = httpx.get(
        f"{rig.url}/api/v1/rig/recorder/picture.png",
        headers={"Authorization": f"Bearer {KEY}"},
        trust_env=False,
    )
    shown = cv2.imdecode(np.frombuffer(picture.content, np.uint8), cv2.IMREAD_UNCHANGED)
    assert shown.shape == (192, 240)

    kept = rig.command("recorder", "erase", typed="n\n")
    assert kept.returncode == 3
    assert "1 sessions" in kept.stdout
    assert len(rig.ask("GET", "/rig/recorder").json()["sessions"]) == 1
    erased = rig.command("recorder", "erase", typed="y\n")
    assert erased.returncode == 0, erased.stderr
    assert rig.ask("GET", "/rig/recorder").json()["sessions"] == []
    for order in ({"key": "jog"}, {"key": "live", "speed": 3}, {"key": "fly"}, {"key": "search"}):
        assert rig.ask("POST", "/rig/recorder", order).status_code == 422, order


@pytest.mark.parametrize(
    ("fault", "said"), [("unplug", "cannot be opened"), ("wrong-device", "something else")]
)
def test_a_recorder_that_is_lost_while_it_runs_is_named_and_obeys_again_once_it_is_back(
    daemon: Daemon, keypad: Keypad, fault: str, said: str
) -> None:
    laboratory: Any = daemon.laboratory

    def jog_from_the_start() -> None:
        # From where a replay has ended there is nothing to play on to.
        keypad.replay()
        keypad.jog(1)

    record(keypad, 50)
    for press, mode in (
        (keypad.record, "RECORD"),
        (keypad.replay, "REPLAY"),
        (jog_from_the_start, "JOG"),
        (keypad.stop, "STOP"),
    ):
        press()
        until(lambda mode=mode: keypad.status().mode == mode)  # type: ignore[misc]
        laboratory.fault("recorder", fault)
        with pytest.raises(DeviceError, match=said):
            keypad.status()
        laboratory.clear_faults()
        assert keypad.status().mode in {mode, "STOP"}
        keypad.stop()
    assert len(keypad.status().sessions) == 2
