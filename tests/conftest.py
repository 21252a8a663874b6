"""Which tests are long: whole stories that `make test-long` runs, and `make test` leaves out.

And what all tests share: examples without a deadline, new catalogues by replay.
"""

from __future__ import annotations

import pytest
from hypothesis import settings

from tests.replayed import replayed_migrations

__all__ = ["replayed_migrations"]

LONG = {
    "test_agreement.py",
    "test_calibrate.py",
    "test_campaign_jobs.py",
    "test_challenge.py",
    "test_demo.py",
    "test_hidden_view.py",
    "test_launch_command.py",
    "test_model_commands.py",
    "test_model_page.py",
    "test_model_pictures.py",
    "test_next_command.py",
    "test_next_shots.py",
    "test_next_shots_page.py",
    "test_own_effects.py",
    "test_page_under_faults.py",
    "test_page_when_busy.py",
    "test_refused_shot.py",
    "test_report_page.py",
    "test_results_pages.py",
    "test_runs.py",
    "test_selection_power.py",
    "test_signature.py",
    "test_sweep_page.py",
    "test_sweeps_live.py",
    "test_table_commands.py",
}
"""Files whose tests take more than a few seconds each; everything else stays in the short run."""


# An example that compiles a function takes seconds, once; each test has a time-out of its own.
settings.register_profile("compiling", deadline=None)
settings.load_profile("compiling")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.path.name in LONG:
            item.add_marker(pytest.mark.long)
