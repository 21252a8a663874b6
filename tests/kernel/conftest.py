"""What a real kernel did: one virtual machine runs every story, and the tests look at each."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.kernel import machine

CACHE = Path(__file__).parents[2] / "out" / "kernel"
Stories = dict[str, list[dict[str, Any]]]


@pytest.fixture(scope="session")
def guest(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Path], Stories]:
    """Return what runs a file in the guest and gives its stories by name."""
    if missing := machine.missing():
        pytest.skip(f"not installed: {', '.join(missing)}; packages {' '.join(machine.PACKAGES)}")
    try:
        unpacked = machine.kernel(CACHE)
    except (subprocess.CalledProcessError, IndexError) as error:
        pytest.skip(f"Debian's kernel cannot be had: {error}")

    def run(module: Path) -> Stories:
        folder = tmp_path_factory.mktemp("guest")
        status, console = machine.run(unpacked, folder, machine.python(module))
        if machine.STARTED not in console:
            pytest.skip(f"the virtual machine does not start here: {console[-400:]}")
        if status == -1 and "Traceback" not in console:
            pytest.skip(f"the virtual machine did not end within {machine.GUEST_S:g} s: busy")
        assert status == 0, console[-4000:]
        stories: Stories = {}
        for line in console.splitlines():
            mark, _, document = line.partition("STORY ")
            if document and not mark.strip():
                story = json.loads(document)
                stories.setdefault(story.pop("story"), []).append(story)
        return stories

    return run
