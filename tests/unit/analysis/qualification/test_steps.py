"""Every step that the explanation of the measurement names can be called on its own."""

import importlib
import re
from pathlib import Path

PAGE = Path(__file__).resolve().parents[4] / "docs" / "explanation" / "measurement.md"


def test_every_function_in_the_table_of_steps_is_there_and_documented() -> None:
    part = PAGE.read_text(encoding="utf-8").partition("each on its own")[2].partition("\n## ")[0]
    cells = [line.split(" | ")[1] for line in part.splitlines() if line.startswith("| ")][1:]
    steps = 0
    for cell in cells:
        module = ""
        for name in re.findall(r"`([\w.]+)`", cell):
            path = name if "." in name else f"{module}.{name}"
            found = re.fullmatch(r"([a-z_.]+)\.(\w+(?:\.\w+)?)", path)
            assert found is not None, path
            module, attributes = found.groups()
            step = importlib.import_module(f"analysis.{module}")
            for attribute in attributes.split("."):
                step = getattr(step, attribute)
            assert step.__doc__, path
            steps += 1
    assert steps >= 16
