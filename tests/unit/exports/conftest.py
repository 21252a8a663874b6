"""One small campaign for all exports."""

from __future__ import annotations

from pathlib import Path

import pytest

from analysis.results.campaign import Results
from rigctl.challenge import new
from rigctl.reports.campaign import measured_results
from rigctl.reports.source import Source, folder_source


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("exported") / "nylon"
    new(place, seed=4, strength="full", shots=10)
    return place


@pytest.fixture(scope="session")
def source(folder: Path) -> Source:
    return folder_source(folder)


@pytest.fixture(scope="session")
def found(source: Source) -> Results:
    return measured_results(source)
