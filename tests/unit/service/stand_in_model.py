"""What jobs of the service compute in these tests."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from rigctl.errors import AnalysisInputError

Json = dict[str, Any]
Say = Callable[[str, float | None], None]


def _answer(asked: Json, say: Say) -> Json:
    say("reading the poses", None)
    results = [own["result"].rpartition("/")[2] for own in asked["files"]]
    return {"campaign": asked["campaign"], "with": asked["with"], "results": results}


ranking_job = agreement_job = structure_job = fit_job = _answer


def next_job(asked: Json, say: Say) -> Json:
    say("choosing shots", None)
    known = {"campaign", "files", "store", "database"}
    return {key: value for key, value in asked.items() if key not in known}


propose_job = next_job


def explain_job(asked: Json, say: Say) -> Json:
    if asked["campaign"] == "broken":
        raise AnalysisInputError("holds no poses", part="result-0001.json", todo="analyse it again")
    say("thinking", 0.5)
    threading.Event().wait()
    return {}
