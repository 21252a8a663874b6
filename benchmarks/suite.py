"""CPU seconds of tests, by folder, file, test and fixture: what a busy machine's clock cannot say.

    python -m benchmarks.suite tests/unit/rig [-m long] [--top 40] [--keep out/suite.json]
    python -m benchmarks.suite --kept out/suite.json [--below tests/unit/rig]

The tests run one after another in this process. A test counts with its fixtures' set-up and
tear-down (a shared fixture counts where it is built first) and with the processes that it started.
Beside it the seconds in which the processor was not used: a test that waits shows there, and so
does a machine that is busy.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePath
from typing import NamedTuple

import pytest

from benchmarks import cpu_seconds


class Spent(NamedTuple):
    """What tests cost: seconds of the processor, seconds without it, and how many they are."""

    cpu_s: float = 0.0
    idle_s: float = 0.0
    times: int = 0

    def plus(self, other: Spent) -> Spent:
        return Spent(self.cpu_s + other.cpu_s, self.idle_s + other.idle_s, self.times + other.times)


Costs = dict[str, Spent]


class CpuSeconds:
    """Plugin of pytest that adds up what each test and each fixture costs."""

    def __init__(self) -> None:
        self._last_s, self._lost_s = 0.0, 0.0
        self.tests: Costs = defaultdict(Spent)
        self.fixtures: Costs = defaultdict(Spent)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        return (yield from self._counted(self.tests, item.nodeid))

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: pytest.FixtureDef[object]) -> Iterator[None]:
        where = fixturedef.baseid or fixturedef.func.__module__
        return (yield from self._counted(self.fixtures, f"{where}::{fixturedef.argname}"))

    def _counted(self, costs: Costs, key: str) -> Iterator[None]:
        cpu, clock = self._so_far_s(), time.monotonic()
        result = yield
        used = self._so_far_s() - cpu
        costs[key] = costs[key].plus(Spent(used, max(0.0, time.monotonic() - clock - used), 1))
        return result

    def _so_far_s(self) -> float:
        """Return it with what went with processes that ended and for which nobody has waited."""
        now = cpu_s()
        self._lost_s += max(0.0, self._last_s - now)
        self._last_s = now
        return now + self._lost_s


def cpu_s() -> float:
    """Return the CPU seconds of this process and of all that it started."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    running = sum(map(cpu_seconds.of_tree, cpu_seconds.children(os.getpid())))
    return running + sum(one.ru_utime + one.ru_stime for one in used)


def table(costs: Mapping[str, Spent], name: str, top: int | None = None) -> None:
    """Print the costs, the most first."""
    print(f"\nCPU s   idle  times {name}")
    for key, spent in sorted(costs.items(), key=lambda each: -each[1].cpu_s)[:top]:
        print(f"{spent.cpu_s:6.2f} {spent.idle_s:6.1f} {spent.times:5} {key}")


def grouped(costs: Mapping[str, Spent], name: str) -> Costs:
    """Return the sums of files or of folders."""
    sums: Costs = defaultdict(Spent)
    for node, spent in costs.items():
        path = PurePath(node.partition("::")[0])
        key = str(path.parent if name == "folder" else path)
        sums[key] = sums[key].plus(spent)
    return sums


def main() -> None:
    """Run the tests, or take what was kept of a run, and print what they cost."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("tests", nargs="*")
    arguments.add_argument("-m", dest="marks", help="of which marks: as pytest takes it")
    arguments.add_argument("--top", type=int, default=40)
    arguments.add_argument("--keep", type=Path, help="write what was measured to this file")
    arguments.add_argument("--kept", type=Path, help="print what an earlier run has kept")
    arguments.add_argument("--below", default="", help="of what was kept, only names that begin so")
    given = arguments.parse_args()
    plugin = CpuSeconds()
    if given.kept is not None:
        kept = json.loads(given.kept.read_text())
        for costs, name in ((plugin.tests, "tests"), (plugin.fixtures, "fixtures")):
            costs.update({key: Spent(*each) for key, each in kept[name].items()})
    else:
        marks = [] if given.marks is None else ["-m", given.marks]
        pytest.main(["-q", "-p", "no:cacheprovider", *marks, *given.tests], plugins=[plugin])
    if given.keep is not None:
        kept = {"tests": plugin.tests, "fixtures": plugin.fixtures}
        given.keep.write_text(json.dumps(kept))
    tests, fixtures = (
        {key: each for key, each in costs.items() if key.startswith(given.below)}
        for costs in (plugin.tests, plugin.fixtures)
    )
    table(tests, "test", given.top)
    table(fixtures, "fixture", given.top)
    table(grouped(tests, "file"), "file")
    table(grouped(tests, "folder"), "folder")
    total = sum((each.cpu_s for each in tests.values()), 0.0)
    print(f"\n{total:.1f} CPU s in {len(tests)} tests, start and collection not counted")


if __name__ == "__main__":
    main()
