"""Films of one ball in Python: each measured once, its bounces the impacts of the campaign."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from hashlib import sha256

import numpy as np

from analysis.arrays import Floats
from analysis.balls.analysis import FilmJob, analyse_film
from analysis.balls.document import ball_document
from analysis.balls.films.reading import PHOTRON_SUFFIXES
from analysis.collision.operator import Body
from analysis.errors import InputError, ShotRefusedError
from analysis.model.data.gather import pose_data
from analysis.model.data.plate import BOUNCES_A_SHOT
from analysis.quantity import Quantity
from analysis.results.impacts import V_N, V_N_AFTER, Impacts, measured_impacts
from rigctl.api.measured import KeptShots, Measured, digest_of, sources
from rigctl.api.progress import counting
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError
from rigctl.measuring.ball_films import BallFilms
from rigctl.measuring.own_film import ball_setup, pose_rows

PICTURE = (480, 640)
"""Rows and columns of a picture in the set-up of poses, in which no picture is looked at."""


@dataclass(frozen=True, slots=True)
class FilmedBall:
    """Films of one ball on a plate."""

    films: BallFilms
    kept: KeptShots = field(default_factory=KeptShots)

    @property
    def name(self) -> str:
        """Name of the campaign."""
        return self.films.name

    def measured(self, workers: int | None) -> Measured:
        """Return the flights of all films; those that were measured before are read.

        One film is measured at a time: `workers` changes nothing.
        """
        documents: dict[int, Json] = {}
        now = 0
        with counting(f"measuring {self.name}") as count:
            for done, job in enumerate(self.films.jobs, start=1):
                key = _key(job)
                document = None if key is None else self.kept.get(key)
                if document is None:
                    document = _measured(job)
                    now += 1
                    if key is not None:
                        self.kept.put(key, document)
                documents[job.shot] = document
                count(done, len(self.films.jobs))
        return self._gathered(documents, now)

    def _gathered(self, documents: Mapping[int, Json], now: int) -> Measured:
        refused = {
            number: _left_out(one) for number, one in documents.items() if "poses" not in one
        }
        poses = {number: one["poses"] for number, one in documents.items() if "poses" in one}
        excluded = {row.shot for row in self.films.rows if row.is_excluded}
        used = sorted(set(poses) - excluded)
        if not used:
            why = next((f"; shot {shot}: {text}" for shot, text in refused.items()), "")
            raise AnalysisInputError(f"no film can be measured{why}", part=self.name)
        job = self.films.jobs[0]
        setup = ball_setup(job.ball, (job.rate_hz, PICTURE), [poses[number] for number in used])
        shots = {number: {"a": pose_rows(one)} for number, one in poses.items()}
        data = pose_data(shots, self.films.rows, setup)
        impacts = _impacts({number: documents[number] for number in used}, data.bodies)
        return Measured(data, refused, now, impacts)


def _impacts(documents: Mapping[int, Json], bodies: tuple[Body, Body]) -> Impacts:
    """Return the bounces of films as they were measured: without spin, and so without v_s.

    The k-th bounce of shot s is impact number 100 s + k, as the fit of poses counts them.
    """
    numbers, velocities, covariance = [], [], []
    for shot, document in documents.items():
        for k, each in enumerate(document["impacts"], start=1):
            before, after, e = (Quantity.from_json(each[key]) for key in ("v_n", "v_n_after", "e"))
            numbers.append(BOUNCES_A_SHOT * shot + k)
            row, spread = np.full(4, np.nan), np.eye(4)
            row[[V_N, V_N_AFTER]] = before.value, after.value
            spread[V_N, V_N], spread[V_N_AFTER, V_N_AFTER] = before.sigma**2, after.sigma**2
            spread[V_N, V_N_AFTER] = spread[V_N_AFTER, V_N] = _shared(before, after, e)
            spread[V_N_AFTER, V_N_AFTER] += _beyond(spread, before, after, e)
            velocities.append(row)
            covariance.append(spread)
    shape = np.array(velocities).reshape(-1, 4), np.array(covariance).reshape(-1, 4, 4)
    return measured_impacts(np.array(numbers, dtype=np.intp), *shape, bodies)


def _shared(before: Quantity, after: Quantity, e: Quantity) -> float:
    """Return the covariance of two speeds whose ratio is as certain as e is.

    The scale, which errs in both alike, leaves e alone.
    """
    ratio = after.value / before.value
    apart = after.sigma**2 + (ratio * before.sigma) ** 2 - (e.sigma * before.value) ** 2
    most = before.sigma * after.sigma
    return float(np.clip(apart / (2.0 * ratio), -most, most))


def _beyond(spread: Floats, before: Quantity, after: Quantity, e: Quantity) -> float:
    """Return the variance of v_n' that no covariance of the speeds holds, (m/s)^2.

    e holds what may err beside the fit, such as pictures that a codec has made alike.
    """
    along = np.zeros(4)
    along[[V_N, V_N_AFTER]] = -after.value / before.value, 1.0
    return max(0.0, (e.sigma * before.value) ** 2 - float(along @ spread @ along))


def _measured(job: FilmJob) -> Json:
    try:
        film = analyse_film(job)
    except InputError as error:
        return {"status": "refused", "step": "frames", "reason": str(error)}
    except ShotRefusedError as refusal:
        return {"status": "refused", "step": refusal.step, "reason": refusal.reason}
    return ball_document(film.measured, film.notes)


def _left_out(document: Json) -> str:
    """Return why a film has no flights on both sides of a bounce."""
    if document["status"] == "refused":
        return f"{document['step']}: {document['reason']}"
    return "; ".join(document["notes"])


def _key(job: FilmJob) -> str | None:
    """Return what a film's result depends on, as one word; None: it cannot be read."""
    content = digest_of(job.path)
    if content is None:
        return None
    if (own := job.path.suffix.lower()) in PHOTRON_SUFFIXES:
        # Pictures lie in one file; their size and rate stand in another.
        others = [job.path.with_suffix(one) for one in PHOTRON_SUFFIXES if one != own]
        content = json.dumps([content, *map(digest_of, others)])
    stated = {**asdict(job), "path": content, "shot": None}
    return sha256(json.dumps([sources(), stated], default=repr).encode()).hexdigest()
