"""Whether a long campaign needs more memory than a short one: python -m benchmarks.long_campaign.

`rigctl analyse --out` and `rigctl reanalyse` go over campaigns of 100 and of more shots, each in a
process of its own. The measuring of a shot, which takes its time and keeps nothing, is stood in
for by a copy of one measured shot: everything around it is the program's own. Prints the largest
resident memory of each process and the ratios, beside the 1.1 that are asked; ends 1 above it.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import pickle
import subprocess
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import Executor, Future
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from unittest import mock

from sqlalchemy import insert

ASKED = 1.1
FEW = 100
MIB = 1024.0
"""ru_maxrss is in KiB."""
FRAMES = 24
TOGETHER = 1000
"""Shots that are put into the store in one transaction."""
NOW = datetime(2026, 1, 1, tzinfo=UTC).isoformat()
SETTINGS = '{"pressure_a_kpa":40.0,"pressure_b_kpa":40.0,"offset_mm":6.0}'


class Inline(Executor):
    """In the place of the processes that analyse: calls at once."""

    def submit(self, call: Callable[..., Any], /, *given: Any, **named: Any) -> Future[Any]:  # noqa: ANN401
        future = Future[Any]()
        future.set_result(call(*given, **named))
        return future


def analyse(shots: int, folder: Path) -> None:
    """Run `rigctl analyse --out` on a campaign of one film under many numbers."""
    import analysis.campaign  # noqa: PLC0415
    from analysis.shot import AnalysisOptions  # noqa: PLC0415
    from rigctl import cli  # noqa: PLC0415
    from simulators.world import write_campaign  # noqa: PLC0415

    write_campaign(folder / "nylon", [40.0], [6.0], 3, frames=FRAMES)
    read = analysis.campaign.read_campaign(folder / "nylon")
    one = analysis.campaign.analyse_job(read.jobs[0], AnalysisOptions())
    listed = folder / "nylon" / "shots.csv"
    head, row = listed.read_text().splitlines()
    rest = row.partition(",")[2]
    with listed.open("w") as file:
        file.write(f"{head}\n")
        file.writelines(f"{k},{rest}\n" for k in range(1, shots + 1))

    stand_in = mock.patch("analysis.campaign.analyse_job", copies(one))
    arguments = ["analyse", str(folder / "nylon"), "--workers", "1", "--json"]
    with stand_in, Path(os.devnull).open("w") as nowhere, contextlib.redirect_stdout(nowhere):
        code = cli.run([*arguments, "--out", str(folder / "out")])
    if code != 0:
        raise RuntimeError(f"rigctl analyse ended with {code}")


def reanalyse(shots: int, folder: Path) -> None:
    """Go over a stored campaign as `rigctl reanalyse` does, each shot with a result before."""
    from rigctl.reanalysis import Comparisons, Pool, reanalyse_campaign  # noqa: PLC0415
    from rigctl.store import Store  # noqa: PLC0415

    poses = [{"frame": k, "position_m": [0.1, 0.2, 0.3], "sigma_m": [1e-5] * 3} for k in range(300)]
    e = {"value": 0.74, "sigma": 0.001, "unit": "1"}
    result = {"status": "measured", "e": e, "poses": poses}
    store = Store(folder / "data")
    fill(store, shots, json.dumps(result))
    compared = Comparisons()
    given = mock.patch("rigctl.measuring.stored_shot.analyse_stored_shot_with", copies(result))
    with given, mock.patch("os.fsync", unforced):
        pool = Pool(Inline(), lambda: 2)
        for outcome in reanalyse_campaign(store, "nylon", "thesis", pool, lambda *_: None):
            compared.add(outcome)
    (found,) = compared.found()
    if found.shots != shots:
        raise RuntimeError(f"{found.shots} of {shots} shots were analysed")
    store.close()


def copies(one: object) -> Callable[..., object]:
    """Return what gives a fresh copy at each call, a tenth as slow as copying part by part."""
    kept = pickle.dumps(one)
    return lambda *_: pickle.loads(kept)


def unforced(_descriptor: int) -> None:
    """In the place of forcing a file to disk, which takes time and no memory."""


def fill(store: Any, shots: int, result: str) -> None:  # noqa: ANN401
    """Put measured shots into a store, without firing them."""
    from rigctl.store.sql.schema import shots as table  # noqa: PLC0415

    common: dict[str, object] = {
        "state": "analysed",
        "outcome": "stored",
        "fired": "yes",
        "settings": SETTINGS,
    }
    common |= {"campaign": "nylon", "actor": "benchmark", "simulated": 1, "configuration": ""}
    common |= {"accepted_at": NOW, "frames": FRAMES, "results": 1}
    for start in range(1, shots + 1, TOGETHER):
        numbers = range(start, min(start + TOGETHER, shots + 1))
        rows = [{"number": k, "id": name_of(k)} for k in numbers]
        with store._database.writing() as connection:
            connection.execute(insert(table).values(**common), rows)
        for k in numbers:
            place = store.folders.folder(name_of(k))
            place.mkdir(parents=True)
            (place / "result-0001.json").write_text(result)


def name_of(number: int) -> str:
    """Return the name of a shot in the store."""
    return f"20260101-{number:06d}"


def measured(kind: str, shots: int) -> float:
    """Return the largest resident memory, MiB, of a process that goes over so many shots."""
    # Removed here: to remove a folder of many takes a list of all that lies in it.
    with tempfile.TemporaryDirectory() as folder:
        asked = ["--child", kind, "--shots", str(shots), "--folder", folder]
        child = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.long_campaign", *asked],
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        )
        _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        raise RuntimeError(f"{kind} of {shots} shots ended with {child.returncode}")
    return usage.ru_maxrss / MIB


def main() -> int:
    """Measure both commands; print what they took."""
    asked = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    asked.add_argument("--shots", type=int, default=2000)
    asked.add_argument("--child", choices=("analyse", "reanalyse"), help=argparse.SUPPRESS)
    asked.add_argument("--folder", type=Path, help=argparse.SUPPRESS)
    options = asked.parse_args()
    if options.child is not None:
        {"analyse": analyse, "reanalyse": reanalyse}[options.child](options.shots, options.folder)
        return 0
    worst = 0.0
    for kind in ("analyse", "reanalyse"):
        few, many = measured(kind, FEW), measured(kind, options.shots)
        worst = max(worst, many / few)
        print(
            f"{kind:10} {FEW} shots: {few:.0f} MiB, {options.shots} shots: {many:.0f} MiB, "
            f"ratio {many / few:.3f} (asked {ASKED:g})"
        )
    return 0 if worst <= ASKED else 1


if __name__ == "__main__":
    sys.exit(main())
