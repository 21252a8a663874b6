"""What the daemon writes to standard error: words for a person, or one JSON object a line."""

from __future__ import annotations

import json
import logging
import sys
from datetime import UTC, datetime
from typing import Literal

from rigctl.errors import RigError
from rigctl.rig.status import Transition
from rigctl.store.records import ShotRecord

LogFormat = Literal["text", "json"]

_log = logging.getLogger("rigctl.rig")


class JsonFormatter(logging.Formatter):
    """Writes `at` (UTC), `level`, `logger`, `message`, and `shot`, `state`, `trace` where known."""

    def format(self, record: logging.LogRecord) -> str:
        """Return one line without a line break."""
        line: dict[str, object] = {
            "at": datetime.fromtimestamp(record.created, UTC).isoformat(),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
        }
        for name in ("shot", "state", "actor"):
            if (value := getattr(record, name, None)) is not None:
                line[name] = str(value)
        if record.exc_info:
            line["trace"] = self.formatException(record.exc_info)
        return json.dumps(line, ensure_ascii=False)


class TextFormatter(logging.Formatter):
    """Writes one line for a person; a trace only of what is no error of the program's own.

    These say what happened, to which part and what to do; JSON lines hold their traces too.
    """

    def format(self, record: logging.LogRecord) -> str:
        """Return the line, and the trace of an error that has no name."""
        if record.exc_info and isinstance(record.exc_info[1], RigError):
            record = logging.makeLogRecord({**record.__dict__, "exc_info": None, "exc_text": None})
        return super().format(record)


def set_up(form: LogFormat) -> None:
    """Write warnings as text, or warnings and every step of rig and shots as JSON lines."""
    handler = logging.StreamHandler(sys.stderr)
    if form == "json":
        handler.setFormatter(JsonFormatter())
    else:
        handler.setFormatter(TextFormatter("rigctl: %(levelname)s: %(message)s"))
    logging.basicConfig(level=logging.WARNING, handlers=[handler])
    _log.setLevel(logging.INFO if form == "json" else logging.WARNING)


def transition(step: Transition) -> None:
    """Write a step of the rig, with the shot it belongs to."""
    known = {"shot": step.shot, "state": step.after, "actor": step.actor}
    _log.info("%s to %s: %s", step.before, step.after, step.reason, extra=known)


def shot(record: ShotRecord) -> None:
    """Write a change of a shot."""
    why = f": {record.failure}" if record.failure else ""
    known = {"shot": record.id, "state": record.state, "actor": record.actor}
    _log.info("shot %s%s", record.state, why, extra=known)
