"""A campaign of rendered frames, one of poses, and a folder of its own for what is kept."""

from __future__ import annotations

from pathlib import Path

import pytest

from rigctl.challenge import new
from simulators.world import write_campaign

SHOTS = 3


@pytest.fixture(scope="session")
def filmed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a campaign folder with frames of three shots."""
    place = tmp_path_factory.mktemp("filmed") / "nylon"
    write_campaign(place, [40.0, 50.0, 60.0], [6.0, 8.0, 10.0], 3, frames=16)
    return place


@pytest.fixture(scope="session")
def mystery(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a campaign folder with poses of forty shots that hide two effects."""
    place = tmp_path_factory.mktemp("posed") / "mystery"
    new(place, seed=2, strength="full", shots=40)
    return place


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder where measured shots are kept, empty at first."""
    monkeypatch.setenv("RIGCTL_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"
