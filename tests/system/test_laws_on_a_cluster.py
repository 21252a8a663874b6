"""Several campaigns asked for a law on a Dask cluster: the answer that one process gives."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rigctl.cli import run
from simulators.challenge import write_challenge

distributed = pytest.importorskip("distributed")
pytestmark = [
    pytest.mark.long,
    pytest.mark.timeout(600),
    # What the cluster's own loop warns of at its end says nothing of the shots.
    pytest.mark.filterwarnings("default"),
]


def test_campaigns_on_a_cluster_share_what_they_share_in_one_process(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folders = [tmp_path / name for name in ("first", "second", "third")]
    for seed, folder in enumerate(folders, start=7):
        write_challenge(folder, {"restitution-temperature": 0.002}, seed=seed, shots=40)
    words = ["model", "propose", str(folders[0]), "--json"]
    words += [part for other in folders[1:] for part in ("--together", str(other))]
    cluster = distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, dashboard_address=None, host="127.0.0.1"
    )
    with cluster:
        assert run([*words, "--scheduler", cluster.scheduler_address]) == 0
    there = json.loads(capsys.readouterr().out)
    assert run(words) == 0
    here = json.loads(capsys.readouterr().out)
    assert there["campaigns"] == here["campaigns"]
    first, again = here["shared"][0], there["shared"][0]
    assert (first["slot"], first["argument"]) == ("e", "temperature_c")
    assert (again["slot"], again["argument"]) == (first["slot"], first["argument"])
    assert again["amplitude"] == pytest.approx(first["amplitude"], rel=1e-6)
