"""How long a filtered page of a large catalogue takes, beside the 50 ms that are asked.

    python benchmarks/catalogue.py [--shots 100000] [--json FILE]

Medians of process time over the repetitions; the folder is temporary.
"""

from __future__ import annotations

import argparse
import json
import statistics
import tempfile
import time
from collections.abc import Callable
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

from sqlalchemy import insert

from rigctl.service.models import ShotList, ShotView
from rigctl.store import ShotState, Store
from rigctl.store.sql.schema import shot_tags, shots

ASKED_MS = 50.0
PAGE = 100
REPEATS = 21
CAMPAIGNS = 50
SETTINGS = '{"pressure_a_kpa":40.0,"pressure_b_kpa":40.0,"offset_mm":6.0}'
START = datetime(2026, 1, 1, tzinfo=UTC)


def fill(store: Store, number: int) -> None:
    """Put shots of many campaigns in turn into a catalogue, one in fifty not measured."""
    rows = []
    for k in range(1, number + 1):
        at = (START + timedelta(seconds=10 * k)).isoformat()
        state = ShotState.REFUSED if k % 50 == 0 else ShotState.ANALYSED
        rows.append(
            {
                "number": k,
                "id": f"20260101-{k:06d}",
                "state": state,
                "outcome": ShotState.STORED,
                "fired": "yes",
                "settings": SETTINGS,
                "campaign": f"campaign-{k % CAMPAIGNS:02d}",
                "actor": "benchmark",
                "simulated": 1,
                "configuration": "0" * 64,
                "accepted_at": at,
                "fired_at": at,
                "ended_at": at,
                "frames": 24,
                "lost": 0,
                "results": 1,
                "excluded": "seen" if k % 1000 == 7 else None,
            }
        )
    tags = [{"shot": k, "tag": "wet"} for k in range(1, number + 1, 97)]
    with store._database.writing() as connection:
        connection.execute(insert(shots), rows)
        connection.execute(insert(shot_tags), tags)


def pages(store: Store, number: int) -> dict[str, Callable[[], object]]:
    """Return the questions that are timed, each as REST would answer it."""
    middle = f"20260101-{number // 2:06d}"

    def page(**wanted: object) -> str:
        found = store.shots(limit=PAGE + 1, **wanted)  # type: ignore[arg-type]
        views = [ShotView.of(shot) for shot in found[:PAGE]]
        return ShotList(shots=views, next=None).model_dump_json()

    return {
        "first page": page,
        "page from the middle": lambda: page(after=middle),
        "one campaign": lambda: page(campaign="campaign-07"),
        "one campaign, from the middle": lambda: page(campaign="campaign-07", after=middle),
        "one campaign, refused": lambda: page(campaign="campaign-00", state=ShotState.REFUSED),
        "refused, from the middle": lambda: page(state=ShotState.REFUSED, after=middle),
        "with a tag": lambda: page(tag="wet"),
        "one campaign with a tag": lambda: page(campaign="campaign-07", tag="wet"),
        "excluded": lambda: page(excluded=True),
        "one campaign, excluded": lambda: page(campaign="campaign-07", excluded=True),
        "one shot": lambda: store.shot(middle),
        "one campaign's counts": lambda: store.campaigns.one("campaign-07"),
        "all campaigns": store.campaigns.all,
    }


def timed(ask: Callable[[], object]) -> float:
    """Return the median process time of a question in ms, after one to warm up."""
    ask()
    taken = []
    for _ in range(REPEATS):
        start = time.process_time()
        ask()
        taken.append(1e3 * (time.process_time() - start))
    return statistics.median(taken)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--shots", type=int, default=100_000)
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    with (
        tempfile.TemporaryDirectory() as folder,
        closing(Store(Path(folder) / "data")) as store,
    ):
        fill(store, asked.shots)
        found = {name: timed(ask) for name, ask in pages(store, asked.shots).items()}
    print(f"{asked.shots} shots, pages of {PAGE}")
    for name, taken in found.items():
        verdict = "" if taken <= ASKED_MS else "  MORE THAN ASKED"
        print(f"{name:32} {taken:8.2f} ms  (asked {ASKED_MS:g}){verdict}")
    if asked.json is not None:
        document = {"shots": asked.shots, "asked_ms": ASKED_MS, "ms": found}
        asked.json.write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main()
