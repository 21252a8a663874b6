"""A start names a device that is missing, and says that the rig is latched: since when and why."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.system.real_rig import RealRig, real_rig

LATCHED = re.compile(r"the rig is latched \((\w+)\) since ([-0-9]{10} [:0-9]{8}) UTC[^:]*: (.*)")


def said_at_the_start(rig: RealRig) -> str:
    """Start a daemon and return what it writes until it is there."""
    log = rig.folder / "serve.log"
    before = len(log.read_text()) if log.exists() else 0
    rig.start()
    return log.read_text()[before:]


@pytest.mark.long
def test_a_trigger_on_the_port_of_a_relay_board_is_named_and_the_latch_outlasts_a_restart(
    tmp_path: Path,
) -> None:
    with real_rig(tmp_path) as rig:
        wrong, right = (str(tmp_path / "laboratory" / role) for role in ("solenoids", "trigger"))
        rig.edit(f'port = "{right}"', f'port = "{wrong}"')
        first = said_at_the_start(rig)
        rig.end()
        missing = next(line for line in first.splitlines() if "without one of its devices" in line)
        for word in ("trigger (trigger-box)", "no answer to 'SAFE", f"may be on {wrong}", "check"):
            assert word in missing
        rig.edit(f'port = "{wrong}"', f'port = "{right}"')
        again = said_at_the_start(rig)
        assert "without one of its devices" not in again
        found = [LATCHED.search(said) for said in (first, again)]
        assert all(found)
        (state, since, why), second = (each.groups() for each in found if each is not None)
        assert (state, since, why) == second
        assert state == "fault"
        assert "trigger (trigger-box)" in why
        assert "rigctl release --config rig.toml" in again
        released = rig.command("release", "the port was another device's")
        assert (released.returncode, "idle" in released.stdout) == (0, True), released.stderr
        rig.end()
        assert "latched" not in said_at_the_start(rig)
