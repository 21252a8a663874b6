"""Threads of one program write one after another, however many there are and however slow."""

from __future__ import annotations

import threading
from pathlib import Path

from rigctl.store.sql.database import Database


def test_writers_that_outlast_the_busy_time_out_together_all_come_through(tmp_path: Path) -> None:
    database = Database(tmp_path / "catalogue.db", busy_timeout_s=0.05)
    held, failures = threading.Event(), list[BaseException]()

    def write() -> None:
        try:
            with database.writing() as connection:
                connection.exec_driver_sql("INSERT OR REPLACE INTO probe VALUES (1, 0.0)")
                # Longer than the busy time-out, so a second writer that polled SQLite would fail.
                held.wait(0.2)
        except BaseException as error:  # noqa: BLE001
            failures.append(error)

    threads = [threading.Thread(target=write) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60.0)
    database.close()
    assert failures == []
