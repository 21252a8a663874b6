"""CPU seconds of tests, by folder, by file and by test: what a busy machine's clock cannot say.

    python -m benchmarks.suite tests/unit/rig [--top 40]

The tests run one after another in this process. A test counts with its fixtures' set-up and
tear-down (a shared fixture counts where it is built first) and with the processes that it started
and that have ended.
"""

from __future__ import annotations

import argparse
import resource
from collections import defaultdict
from collections.abc import Iterator, Mapping
from pathlib import PurePath

import pytest


class CpuSeconds:
    """Plugin of pytest that adds up what each test spends."""

    def __init__(self) -> None:
        self.spent: dict[str, float] = defaultdict(float)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        before = cpu_s()
        result = yield
        self.spent[item.nodeid] += cpu_s() - before
        return result


def cpu_s() -> float:
    """Return the CPU seconds of this process and of its children that have ended."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def dearest(spent: Mapping[str, float]) -> list[tuple[str, float]]:
    """Return names with their CPU seconds, the most first."""
    return sorted(spent.items(), key=lambda each: -each[1])


def grouped(spent: Mapping[str, float], name: str) -> None:
    """Print the sums of files or of folders."""
    sums: dict[str, float] = defaultdict(float)
    for node, seconds in spent.items():
        path = PurePath(node.partition("::")[0])
        sums[str(path.parent if name == "folder" else path)] += seconds
    print(f"\nCPU s  {name}")
    for key, seconds in dearest(sums):
        print(f"{seconds:6.1f} {key}")


def main() -> None:
    """Run the tests and print what they spent."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("tests", nargs="+")
    arguments.add_argument("--top", type=int, default=40)
    given = arguments.parse_args()
    plugin = CpuSeconds()
    began = cpu_s()
    pytest.main(["-q", "-p", "no:cacheprovider", *given.tests], plugins=[plugin])
    total, tests = cpu_s() - began, sum(plugin.spent.values())
    print("\nCPU s  test")
    for node, seconds in dearest(plugin.spent)[: given.top]:
        print(f"{seconds:6.2f} {node}")
    grouped(plugin.spent, "file")
    grouped(plugin.spent, "folder")
    print(f"\n{total:.1f} CPU s, {tests:.1f} of them in {len(plugin.spent)} tests")


if __name__ == "__main__":
    main()
