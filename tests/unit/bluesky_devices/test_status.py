import threading

import pytest

pytest.importorskip("bluesky")

from rigctl.bluesky_devices.rig import WorkStatus

BOUND_S = 20.0


def test_a_callback_that_fails_keeps_none_from_being_called_and_is_logged(
    caplog: pytest.LogCaptureFixture,
) -> None:
    go, called = threading.Event(), threading.Event()
    status = WorkStatus("the work", lambda: bool(go.wait(BOUND_S)) and None)

    def failing(_: object) -> None:
        raise RuntimeError("the engine is closed")

    status.add_callback(failing)
    status.add_callback(lambda _: called.set())
    go.set()
    assert called.wait(BOUND_S)
    assert status.success
    assert "the work has ended, and a callback of it failed" in caplog.text
