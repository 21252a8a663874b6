"""A campaign that came as a table alone is answered by REST as any other."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rigctl.exchange.contents import read_contents
from rigctl.exchange.importing import import_campaign
from rigctl.jobs import Jobs
from rigctl.store import Store
from tests.unit.analysis.model.tabulated import contacts

WAIT_S = 150.0
"""A first analysis on a machine compiles."""
TABLES = "/api/v1/campaigns/tables"

pytestmark = pytest.mark.timeout(600)


def silent(_text: str, _share: float | None) -> None:
    """Say nothing."""


@pytest.fixture
def tables(store: Store, tmp_path: Path) -> None:
    """Import twenty contacts whose law is known."""
    contents = read_contents(contacts(tmp_path / "tables", 20, 62), silent)
    import_campaign(store, contents, "anna", name="tables", progress=silent)


@pytest.mark.usefixtures("tables")
def test_the_ranking_of_a_table_comes_by_a_job_of_its_own(ask: Any, jobs: Jobs) -> None:
    first = ask("GET", f"{TABLES}/ranking")
    job = jobs.wait(first.json()["job"], WAIT_S)
    assert job.state == "done", job
    found = ask("GET", f"{TABLES}/ranking").json()
    assert (found["campaign"], found["shots"]) == ("tables", 20)
    # The law that the table was drawn by.
    assert found["parameters"]["e"]["value"] == pytest.approx(0.74, abs=0.01)
