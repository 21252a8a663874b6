"""Campaigns of frames: each shot is measured once, and kept."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from analysis.campaign import Campaign, analyse_campaign
from analysis.exchange.pose_table import PoseRow
from analysis.exchange.shot_list import ShotRow
from analysis.model.data.gather import pose_data
from analysis.model.predict.start import both_seen
from analysis.setup import SlowErrors
from analysis.shot import AnalysisOptions, Method
from analysis.slow_errors import typical
from rigctl.api.kept_shots import KeptShots, shot_keys
from rigctl.api.measured import Measured
from rigctl.api.progress import counting
from rigctl.errors import AnalysisInputError
from rigctl.input_errors import as_analysis_errors
from rigctl.measuring.first_analysis import wait_for_compiler
from rigctl.measuring.stored_poses import measured_document, poses_of, slow_errors_of

Json = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Frames:
    """A folder of frames with its set-up, or loose frames."""

    campaign: Campaign
    method: Method
    kept: KeptShots = field(default_factory=KeptShots)

    @property
    def name(self) -> str:
        """Name of the campaign."""
        return self.campaign.name

    def measured(self, workers: int | None) -> Measured:
        """Return poses of all shots; those that were measured before are read."""
        with as_analysis_errors():
            keys = shot_keys(self.campaign.jobs, self.method)
            documents = {
                number: document
                for number, key in keys.items()
                if (document := self.kept.get(key)) is not None
            }
            before = len(documents)
            documents |= self._measured_now(keys, documents, workers)
        return self._gathered(documents, now=len(documents) - before)

    def _measured_now(
        self, keys: Mapping[int, str], there: Mapping[int, Json], workers: int | None
    ) -> Iterator[tuple[int, Json]]:
        """Measure what is not there; each shot is kept as soon as it is measured."""
        jobs = self.campaign.jobs
        if len(there) == len(jobs):
            return
        options = AnalysisOptions(method=self.method)
        wait = wait_for_compiler(self.method)
        first = "" if wait is None else f" (compiling first, about {wait}, once)"
        with counting(f"measuring {self.name}{first}") as count:
            done = analyse_campaign(self.campaign, options, workers, count, frozenset(there))
            for job, shot, frames in done:
                document = measured_document(shot)
                if frames and job.shot in keys:
                    self.kept.put(keys[job.shot], document)
                yield job.shot, document

    def _gathered(self, documents: Mapping[int, Json], now: int) -> Measured:
        shots: dict[int, dict[str, list[PoseRow]]] = {}
        errors: list[SlowErrors] = []
        refused: dict[int, str] = {}
        rows = [job.row or ShotRow(job.shot, None, {}, {}) for job in self.campaign.jobs]
        for row in rows:
            document = documents[row.shot]
            if document["status"] != "measured":
                refused[row.shot] = f"{document['step']}: {document['reason']}"
                continue
            slow = slow_errors_of(document["slow_errors"])
            shots[row.shot] = poses_of(document["poses"], slow)
            errors.append(slow)
        counting_shots = set(shots) - {row.shot for row in rows if row.is_excluded}
        setup = typical(next(iter(self.campaign.jobs)).setup, errors)
        data = pose_data(shots, rows, setup) if counting_shots else None
        if data is None or not both_seen(data.position_sigma).any():
            why = next((f"; shot {shot}: {text}" for shot, text in refused.items()), "")
            raise AnalysisInputError(f"no shot can be measured{why}", part=self.name)
        return Measured(data, refused, now)
