"""What is asked beside what was measured."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path

OUT = Path("out")


@dataclass(frozen=True, slots=True)
class Line:
    """A number, the most or least that is asked of it, and its unit."""

    name: str
    value: float
    goal: float
    unit: str
    at_least: bool


@dataclass(slots=True)
class Sheet:
    """The numbers of a section, printed as they come."""

    section: str
    lines: list[Line] = field(default_factory=list)

    def at_most(self, name: str, value: float, goal: float, unit: str = "") -> None:
        self._add(Line(name, float(value), goal, unit, at_least=False))

    def at_least(self, name: str, value: float, goal: float, unit: str = "") -> None:
        self._add(Line(name, float(value), goal, unit, at_least=True))

    def write(self) -> None:
        OUT.mkdir(exist_ok=True)
        rows = [asdict(line) for line in self.lines]
        (OUT / f"imaging-{self.section}.json").write_text(json.dumps(rows, indent=2) + "\n")

    def _add(self, line: Line) -> None:
        self.lines.append(line)
        reached = line.value >= line.goal if line.at_least else line.value <= line.goal
        asked = f"{'at least' if line.at_least else 'at most'} {line.goal:g}"
        verdict = "" if reached else "  NOT REACHED"
        print(f"  {line.name}: {line.value:.4g} {line.unit}, asked {asked}{verdict}", flush=True)
