"""`rigctl precompile`: compile the analysis for this machine; no first shot waits for it."""

from __future__ import annotations

import tempfile
from pathlib import Path

from analysis.campaign import analyse_campaign, read_campaign
from analysis.effects.catalogue import CATALOGUE
from analysis.effects.contact import lasting_contact
from analysis.model.data.gather import gather
from analysis.model.fitting.robust_fit import judged
from analysis.model.verdict.selection import explain
from analysis.shot import AnalysisOptions, Method
from analysis.workers import Workers
from rigctl.challenge import new
from rigctl.cli.output import progress

FILMED, TABULATED = 4, 20
"""Shots of the two small campaigns: one to be measured, one to be explained."""


def precompile() -> None:
    """Measure a small simulated campaign by both methods, and explain another, in two processes.

    What is compiled already takes seconds.

    Raises
    ------
    StoreError
        There is no room for temporary files.
    WorkerDiedError
        A process was killed.
    """
    with tempfile.TemporaryDirectory() as folder, Workers(2) as workers, progress() as report:
        filmed, tabulated = Path(folder) / "filmed", Path(folder) / "tabulated"
        new(filmed, seed=5, strength="full", shots=FILMED, from_frames=True)
        new(tabulated, seed=5, strength="full", shots=TABULATED)
        parts = [
            workers.submit(_measure, filmed, "photometric"),
            workers.submit(_explain, tabulated),
            workers.submit(_measure, filmed, "thesis"),
        ]
        for done, part in enumerate(parts):
            report(f"compiling: {done} of {len(parts)} parts")
            part.result()


def _measure(folder: Path, method: Method) -> None:
    for _ in analyse_campaign(read_campaign(folder), AnalysisOptions(method=method), workers=1):
        pass


def _explain(folder: Path) -> None:
    data = gather(folder)[1]
    judged(data, (lasting_contact.EFFECT,))
    explain(data, CATALOGUE)
