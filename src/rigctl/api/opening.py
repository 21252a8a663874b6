"""From what a person has, to a campaign."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

from analysis.balls.films.frames import FRAME_SUFFIXES, holds_frames
from analysis.campaign import DESCRIPTION, POSES, joined, read_campaign
from analysis.campaign import Campaign as Shots
from analysis.effects.effect import Effect
from analysis.exchange.description import read_description
from analysis.model.data.gather import CONTACTS, IMPACTS, gather
from analysis.shot import Method
from rigctl.api.campaign import Campaign
from rigctl.api.measured import Frames, Measured, Source
from rigctl.api.own_effects import KnownEffects
from rigctl.input_errors import as_analysis_errors


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

    Raises
    ------
    AnalysisInputError
        It cannot be read, or the folder of effects cannot.
    """
    known = KnownEffects.of(Path(effects) if isinstance(effects, str | PathLike) else effects)
    with as_analysis_errors():
        return Campaign(_source(source, method, setup, config), known)


def _source(
    source: Place | Sequence[Place], method: Method, setup: Place | None, config: Place | None
) -> Source:
    if not isinstance(source, str | PathLike):
        return Frames(_films([Path(place) for place in source], setup), method)
    path = Path(source)
    if not path.exists() and len(path.parts) == 1:
        return Named(str(path), None if config is None else Path(config))
    if path.name in TABLES or any((path / table).exists() for table in TABLES):
        return Tables(path)
    if path.is_dir() and not (path / DESCRIPTION).exists() and not holds_frames(path):
        inside = sorted(path.iterdir())
        films = [one for one in inside if one.suffix.lower() in FRAME_SUFFIXES or _is_film(one)]
        if films:
            return Frames(replace(_films(films, setup), name=path.resolve().name), method)
    return Frames(_films([path], setup), method)


def _is_film(path: Path) -> bool:
    return path.is_dir() and holds_frames(path)


def _films(paths: Sequence[Path], setup: Place | None) -> Shots:
    stated = None if setup is None else read_description(Path(setup))[1]
    return joined([read_campaign(path, stated) for path in paths])
