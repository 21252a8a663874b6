from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rigctl.store import ShotState, Store
from tests.unit.reanalysis.stored_campaign import firing, stored

Json = dict[str, Any]


@pytest.fixture
def shots(store: Store) -> list[str]:
    """Three stored shots of a campaign, and one that misfired."""
    names = [stored(store) for _ in range(3)]
    store.move(firing(store), ShotState.MISFIRE)
    return names


@pytest.fixture
def answers(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[[str, str], Json]], None]:
    """Let a function of a shot's name and the method stand in for the analysis."""

    def use(answer: Callable[[str, str], Json]) -> None:
        def analyse(folder: Path, method: str, known: None) -> Json:
            return answer(folder.name, method)

        monkeypatch.setattr("rigctl.measuring.stored_shot.analyse_stored_shot_with", analyse)

    return use
