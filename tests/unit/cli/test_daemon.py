from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rigctl.config import Configuration, Simulation, StoreSection, default_path, load
from rigctl.daemon import open_daemon
from rigctl.errors import ConfigurationError, DeviceAbsentError
from rigctl.store import Store
from tests.invoked import rigctl


def simulated(folder: Path, factory: str, **options: Any) -> Configuration:
    return load().model_copy(
        update={
            "store": StoreSection(folder=str(folder)),
            "simulation": Simulation(factory=factory, **options),
        }
    )


FACTORIES = [
    ("no_such_module:open", "no_such_module"),
    ("simulators.laboratory:no_such_function", "no_such_function"),
]


@pytest.mark.parametrize(("factory", "named"), FACTORIES)
def test_a_factory_that_is_not_there_is_named_and_the_store_let_go(
    tmp_path: Path, factory: str, named: str
) -> None:
    with (
        pytest.raises(ConfigurationError, match=named) as raised,
        open_daemon(simulated(tmp_path, factory)),
    ):
        pass
    assert raised.value.part == "simulation.factory"
    Store(tmp_path).close()


def test_an_option_the_laboratory_does_not_know_is_named(tmp_path: Path) -> None:
    configuration = simulated(tmp_path, "simulators.laboratory:open_laboratory", sead=1)
    with pytest.raises(ConfigurationError, match="sead"), open_daemon(configuration):
        pass
    Store(tmp_path).close()


def test_a_real_rig_whose_devices_are_absent_says_which_and_lets_the_store_go(
    tmp_path: Path,
) -> None:
    example = Path(__file__).parents[3] / "config" / "pusher.toml"
    configuration = load(example).model_copy(update={"store": StoreSection(folder=str(tmp_path))})
    with pytest.raises(DeviceAbsentError) as raised, open_daemon(configuration):
        pass
    assert raised.value.part is not None
    Store(tmp_path).close()


def until(condition: Callable[[], bool]) -> None:
    """Return once the condition holds: a board that gives no answer takes its bytes in its time."""
    deadline = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.001)


def test_a_failure_inside_leaves_power_off_and_everything_closed(tmp_path: Path) -> None:
    configuration = simulated(tmp_path, "simulators.laboratory:open_laboratory", seed=1)
    kept: list[Any] = []

    def fail_while_powered() -> None:
        with open_daemon(configuration) as daemon:
            kept.append(daemon.laboratory)
            until(lambda: kept[0].state()["powered"] is True)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail_while_powered()
    assert kept[0].state()["powered"] is False
    Store(tmp_path).close()


@pytest.mark.parametrize("port", ["sim:trigger", "sim:regulator", "sim:slide", "sim:cut-off"])
def test_a_simulated_port_that_nobody_knows_ends_the_start_as_bad_input(
    tmp_path: Path, port: str
) -> None:
    text = default_path().read_text().replace(f'"{port}"', '"sim:valve"')
    (tmp_path / "rig.toml").write_text(text)
    ended = rigctl("serve", "--config", "rig.toml", "--port", "0", folder=tmp_path)
    assert ended.returncode == 2
    assert ended.stderr.startswith("rigctl: sim:valve: ")
    assert ended.stderr.count("\n") == 1
    Store(tmp_path / "data").close()
