"""From what a person has to a campaign: frames, poses, tables, or films of one ball.

Each film of a ball is measured once; its bounces are the impacts of the campaign.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from hashlib import sha256
from os import PathLike
from pathlib import Path

import numpy as np

from analysis.arrays import Floats
from analysis.balls.analysis import FilmJob
from analysis.balls.films.frames import FRAME_SUFFIXES, holds_frames
from analysis.balls.films.part import Cut
from analysis.balls.films.reading import PHOTRON_SUFFIXES
from analysis.campaign import DESCRIPTION, POSES, joined, read_campaign
from analysis.campaign import Campaign as Shots
from analysis.collision.operator import Body
from analysis.effects.effect import Effect
from analysis.errors import InputError, ShotRefusedError
from analysis.exchange.description import read_description
from analysis.model.data.gather import CONTACTS, IMPACTS, gather, pose_data
from analysis.model.data.plate import BOUNCES_A_SHOT
from analysis.quantity import Quantity
from analysis.results.impacts import V_N, V_N_AFTER, Impacts, measured_impacts
from analysis.shot import Method
from rigctl.api.campaign import Campaign
from rigctl.api.measured import Frames, KeptShots, Measured, Source, digest_of, sources
from rigctl.api.own_effects import KnownEffects
from rigctl.api.progress import counting
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError
from rigctl.input_errors import as_analysis_errors
from rigctl.measuring.ball_films import BallFilms, Stated, ball_films, shows_one_ball
from rigctl.measuring.ball_results import ball_result
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
        own = (impact for impact in document["impacts"] if not impact.get("surface"))
        for k, each in enumerate(own, start=1):
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
        return ball_result(job).document
    except InputError as error:
        return {"status": "refused", "step": "frames", "reason": str(error)}
    except ShotRefusedError as refusal:
        return {"status": "refused", "step": refusal.step, "reason": refusal.reason}


def _left_out(document: Json) -> str:
    """Return why a film has no flights on both sides of a bounce."""
    if document["status"] == "refused":
        return f"{document['step']}: {document['reason']}"
    if document["impacts"] and "poses" not in document:
        return (
            "bounces that were heard have no flights; write them with rigctl analyse --out FOLDER "
            "and open that folder"
        )
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


@dataclass(frozen=True, slots=True)
class Tables:
    """An exchange folder with contacts.csv, impacts.csv or poses.csv, or one of these files."""

    path: Path

    @property
    def name(self) -> str:
        """Name of the campaign."""
        folder = self.path.parent if self.path.is_file() else self.path
        with as_analysis_errors():
            return read_description(folder / DESCRIPTION)[0]

    def measured(self, workers: int | None) -> Measured:
        """Return what the tables hold, of the latest stage that is there."""
        with as_analysis_errors():
            return Measured(gather(self.path)[1])


@dataclass(frozen=True, slots=True)
class Named:
    """A campaign in the store of a configuration; its daemon measures the shots."""

    name: str
    configuration: Path | None

    def measured(self, workers: int | None) -> Measured:
        """Return the shots that are measured; those that are not are refused by name."""
        # The store needs a system with file locks; folders do not.
        from rigctl.model.campaigns import open_campaign  # noqa: PLC0415

        return Measured(open_campaign(Path(self.name), self.configuration)[1])


Place = str | PathLike[str]
TABLES = (CONTACTS, IMPACTS, POSES)


def open_campaign(
    source: Place | Sequence[Place],
    *,
    effects: Place | Sequence[Effect] | None = None,
    method: Method = "photometric",
    setup: Place | None = None,
    config: Place | None = None,
    ball_diameter_mm: float | None = None,
    ball_mass_g: float | None = None,
    fps: float | None = None,
    exposure_us: float | None = None,
    roi: tuple[int, int, int, int] | None = None,
    frames: tuple[int, int | None] | None = None,
    lens: Place | None = None,
) -> Campaign:
    """Open a campaign; nothing is measured yet.

    Parameters
    ----------
    source
        A campaign folder with frames, or with poses.csv, impacts.csv or contacts.csv, of which the
        latest stage is taken, or the one of these files that is named; a film (TIFF, NPY, AVI, PNG
        folder), a folder of films, or several films, each a shot; else the name of a campaign in
        the store.
    effects
        Effects of one's own, ranked and found by name beside the catalogue: a folder, a file, or
        the effects themselves. Files are run.
    method
        How frames are measured.
    setup
        A campaign.toml for films that lie in no campaign folder; None: the thesis's set-up.
    config
        Configuration of the rig whose store is meant; None: the simulated rig's.
    ball_diameter_mm
        Films of one ball that bounces on a plate: its diameter, mm. None: as the campaign's folder
        has it, where sphere b is a plate; else films show two marked spheres.
    ball_mass_g
        Of that ball, g: the drag of the air follows.
    fps, exposure_us
        Frames a second of the camera that filmed the ball, and its exposure in us; None: as the
        files say, and from the smear.
    roi, frames
        Part of a ball's film to look at: column, row, width and height; the first frame and the one
        after the last.
    lens
        lens.toml of the camera that filmed the ball.

    Raises
    ------
    AnalysisInputError
        It cannot be read, or the folder of effects cannot; or something is stated of a ball that is
        for films of one only.
    """
    known = KnownEffects.of(Path(effects) if isinstance(effects, str | PathLike) else effects)
    first, last = frames or (0, None)
    stated = Stated(
        diameter_mm=ball_diameter_mm,
        mass_g=ball_mass_g,
        rate_hz=fps,
        exposure_us=exposure_us,
        cut=None if roi is None and frames is None else Cut(first, last, roi),
        lens=None if lens is None else Path(lens),
        setup=None if setup is None else Path(setup),
    )
    with as_analysis_errors():
        found = _filmed_ball(source, stated) or _source(source, method, setup, config)
        if not isinstance(found, FilmedBall) and stated != Stated(setup=stated.setup):
            held = isinstance(found, Tables)
            raise AnalysisInputError(
                "diameter, mass, frame rate, exposure, part and lens are for films of one ball",
                part=str(source),
                todo="leave them out: this holds tables, whose campaign.toml says what they need"
                if held
                else "state the ball's diameter too, ball_diameter_mm=40, or leave them out",
            )
        return Campaign(found, known)


def _filmed_ball(source: Place | Sequence[Place], stated: Stated) -> FilmedBall | None:
    """Return films of one ball; None where neither a diameter nor a set-up says that they are."""
    name = None
    if isinstance(source, str | PathLike):
        place = Path(source)
        if _holds_table(place):
            return None
        paths = [place]
        if inside := _films_inside(place):
            paths, name = inside, place.resolve().name
    else:
        paths = [Path(each) for each in source]
    if stated.diameter_mm is None and not all(shows_one_ball(p, stated.setup) for p in paths):
        return None
    for path in paths:
        if not path.exists():
            raise InputError(path, "no such file or folder")
    films = ball_films(paths, stated)
    _require_one_ball(films.jobs)
    return FilmedBall(films if name is None else replace(films, name=name))


def _require_one_ball(jobs: Sequence[FilmJob]) -> None:
    """Refuse films of unlike balls: one law with one size and one mass is fitted to all."""
    for job in jobs:
        if job.ball != jobs[0].ball:
            raise AnalysisInputError(
                f"shows another ball than {jobs[0].path}: {job.ball} and {jobs[0].ball}",
                part=str(job.path),
                todo="open the films of each ball by themselves, or state ball_diameter_mm",
            )


def _holds_table(path: Path) -> bool:
    return path.name in TABLES or any((path / table).exists() for table in TABLES)


def _films_inside(path: Path) -> list[Path]:
    """Return the films of a folder that is neither one itself nor a campaign's."""
    if not path.is_dir() or (path / DESCRIPTION).exists() or holds_frames(path):
        return []
    return [one for one in sorted(path.iterdir()) if _is_film(one)]


def _source(
    source: Place | Sequence[Place], method: Method, setup: Place | None, config: Place | None
) -> Source:
    if not isinstance(source, str | PathLike):
        return Frames(_films([Path(place) for place in source], setup), method)
    path = Path(source)
    if not path.exists() and len(path.parts) == 1:
        return Named(str(path), None if config is None else Path(config))
    if _holds_table(path):
        return Tables(path)
    if films := _films_inside(path):
        return Frames(replace(_films(films, setup), name=path.resolve().name), method)
    return Frames(_films([path], setup), method)


def _is_film(path: Path) -> bool:
    return path.suffix.lower() in FRAME_SUFFIXES or (path.is_dir() and holds_frames(path))


def _films(paths: Sequence[Path], setup: Place | None) -> Shots:
    stated = None if setup is None else read_description(Path(setup))[1]
    return joined([read_campaign(path, stated) for path in paths])
