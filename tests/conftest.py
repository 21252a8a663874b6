"""Which tests are long: whole stories that `make test-long` runs, and `make test` leaves out."""

from __future__ import annotations

import pytest

LONG = {
    "test_agreement.py",
    "test_challenge.py",
    "test_demo.py",
    "test_killed_sweeps.py",
    "test_model_page.py",
    "test_model_pictures.py",
    "test_next_command.py",
    "test_next_shots.py",
    "test_own_effects.py",
    "test_page_under_faults.py",
    "test_refused_shot.py",
    "test_runs.py",
    "test_selection_power.py",
    "test_signature.py",
    "test_sweep_page.py",
    "test_sweeps_live.py",
}
"""Files whose tests take more than a few seconds each; everything else stays in the short run."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.path.name in LONG:
            item.add_marker(pytest.mark.long)
