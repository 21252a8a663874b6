"""The same campaign on a process pool and on a Dask cluster: the same results, to rounding."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from rigctl.challenge import new
from rigctl.exchange.contents import read_contents
from rigctl.exchange.importing import import_campaign
from rigctl.reanalysis import pool, reanalyse_campaign
from rigctl.store import Store

distributed = pytest.importorskip("distributed")
pytestmark = [
    pytest.mark.long,
    pytest.mark.timeout(600),
    # What the cluster's own loop warns of at its end says nothing of the shots.
    pytest.mark.filterwarnings("default"),
]

METHODS = ("thesis", "photometric")


def silent(_text: str, _share: float | None) -> None:
    """Say nothing."""


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Store]:
    folder = tmp_path_factory.mktemp("cluster")
    new(folder / "nylon", seed=5, strength="full", shots=4, from_frames=True)
    with closing(Store(folder / "data")) as opened:
        contents = read_contents(folder / "nylon", silent)
        import_campaign(opened, contents, "anna", name="nylon", progress=silent)
        yield opened


def assert_alike(found: object, other: object) -> None:
    """Compare documents whose numbers were added up in another order."""
    if isinstance(other, dict) and isinstance(found, dict):
        assert list(found) == list(other)
        found, other = list(found.values()), list(other.values())
    if isinstance(other, list) and isinstance(found, list):
        assert len(found) == len(other)
        for one, two in zip(found, other, strict=True):
            assert_alike(one, two)
    elif isinstance(other, float):
        assert found == pytest.approx(other, rel=1e-6, abs=1e-12)
    else:
        assert found == other


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    cluster = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1"
    )
    with cluster:
        yield str(cluster.scheduler_address)


def results(store: Store, number: int) -> list[dict[str, object]]:
    folders = [store.folders.folder(shot.id) for shot in store.shots(campaign="nylon")]
    files = [Path(folder) / f"result-{number:04d}.json" for folder in folders]
    return [json.loads(file.read_text(encoding="utf-8")) for file in files]


def test_a_cluster_gives_the_results_of_this_host(store: Store, scheduler: str) -> None:
    known = store.shots(campaign="nylon")[0].results
    for address in (None, scheduler):
        with pool(address, workers=2) as workshop:
            assert workshop.workers() == 2
            for method in METHODS:
                outcomes = list(reanalyse_campaign(store, "nylon", method, workshop, silent))
                assert [outcome.failure for outcome in outcomes] == [None] * 4
    for number, _ in enumerate(METHODS, start=known + 1):
        here, there = results(store, number), results(store, number + len(METHODS))
        assert_alike(here, there)
        # Outlines cannot tell how one of these spheres is turned.
        assert sum("poses" in result for result in here) >= 3
