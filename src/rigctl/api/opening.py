"""From what a person has, to a campaign."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

from analysis.balls.analysis import FilmJob
from analysis.balls.films.frames import FRAME_SUFFIXES, holds_frames
from analysis.balls.films.part import Cut
from analysis.campaign import DESCRIPTION, POSES, joined, read_campaign
from analysis.campaign import Campaign as Shots
from analysis.effects.effect import Effect
from analysis.errors import InputError
from analysis.exchange.description import read_description
from analysis.model.data.gather import CONTACTS, IMPACTS, gather
from analysis.shot import Method
from rigctl.api.ball_films import FilmedBall
from rigctl.api.campaign import Campaign
from rigctl.api.measured import Frames, Measured, Source
from rigctl.api.own_effects import KnownEffects
from rigctl.errors import AnalysisInputError
from rigctl.input_errors import as_analysis_errors
from rigctl.measuring.ball_films import Stated, ball_films, shows_one_ball


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
