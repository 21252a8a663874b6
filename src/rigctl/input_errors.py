"""Faults of files that are handed in, as the errors of this program."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from analysis.errors import InputError
from rigctl.errors import AnalysisInputError


@contextmanager
def as_analysis_errors(todo: str | None = None) -> Iterator[None]:
    """Turn `InputError` of the analysis into `AnalysisInputError`, with file and line.

    Parameters
    ----------
    todo
        What is to be done about any of them.
    """
    try:
        yield
    except InputError as error:
        place = error.path if error.line is None else f"{error.path}, line {error.line}"
        raise AnalysisInputError(error.reason, part=place, todo=todo) from error
