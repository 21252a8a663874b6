"""From a campaign to its report, and to the tables behind it."""

from __future__ import annotations

from pathlib import Path

from analysis.results.campaign import Results, results
from analysis.results.lines import TooFewShotsError
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError
from rigctl.progress import Progress
from rigctl.reports.page import page
from rigctl.reports.source import Source, stored_source
from rigctl.store import reading


def measured_results(source: Source) -> Results:
    """Return the results of a campaign.

    Raises
    ------
    AnalysisInputError
        No shot has a measured impact.
    """
    try:
        return results(source.data)
    except TooFewShotsError as error:
        raise AnalysisInputError(
            str(error), part=source.title, todo="look at why its shots were left out"
        ) from error


def report_job(asked: Json, progress: Progress) -> Json:
    """Make the report of a campaign in the catalogue, in a process of its own.

    Parameters
    ----------
    asked
        `store`, the store's folder; `database`, the URL of its catalogue, null: a file in the
        folder; and `campaign`.
    """
    progress("reading the poses", 0.1)
    with reading(Path(asked["store"]), asked["database"]) as store:
        source = stored_source(store, asked["campaign"])
    progress("fitting", 0.3)
    found = measured_results(source)
    progress("drawing", 0.8)
    return {"campaign": source.title, "html": page(source, found)}
