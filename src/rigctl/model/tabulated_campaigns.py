"""Imported campaigns of which only tables of contacts are known, as their folder gives them."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from analysis.campaign import POSES
from analysis.model.data.gather import CONTACTS, IMPACTS, gather
from analysis.model.data.poses import PoseData
from analysis.model.data.tables import Data
from rigctl.errors import AnalysisInputError, NotFoundError
from rigctl.exchange.exporting import export_campaign, listing
from rigctl.store import StoreReader


def is_tabulated(store: StoreReader, name: str) -> bool:
    """Say whether a campaign came with tables, and no shot of it has poses, then or since."""
    try:
        home, digest = store.imports.of(name)
    except NotFoundError:
        return False
    files = listing(home, digest)
    return (
        POSES not in files
        and not {CONTACTS, IMPACTS}.isdisjoint(files)
        and all(shot.results <= 1 for shot in store.catalogue.each(name))
    )


def tabulated(store: StoreReader, name: str) -> Data:
    """Return the contacts of such a campaign, without the shots that a person excluded since.

    Raises
    ------
    InputError
        No shot counts.
    StoreError
        A file is not the one that was imported.
    """
    with TemporaryDirectory() as place:
        folder = Path(place) / "exported"
        # What would be handed on is what is fitted: exclusions stand in its shots.csv.
        export_campaign(store, name, folder, progress=lambda _text, _share: None)
        return gather(folder)[1]


def require_poses(title: str, data: Data) -> PoseData:
    """Return poses; a table of contacts has none.

    Raises
    ------
    AnalysisInputError
        It is a table.
    """
    if isinstance(data, PoseData):
        return data
    raise AnalysisInputError(
        "tabulated contacts do not say what a shot elsewhere would show",
        part=title,
        todo="give its poses",
    )
