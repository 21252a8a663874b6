"""Imported campaigns of which only tables of contacts are known, as their folder gives them."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from analysis.campaign import POSES
from analysis.model.gather import CONTACTS, IMPACTS, gather
from analysis.model.tables import Data
from rigctl.errors import NotFoundError
from rigctl.exchange.exporting import export_campaign, listing
from rigctl.measured import MOST_SHOTS
from rigctl.store import StoreReader


def is_tabulated(store: StoreReader, name: str) -> bool:
    """Say whether a campaign came with tables, and no shot of it has poses, then or since."""
    try:
        home, digest = store.imports.of(name)
    except NotFoundError:
        return False
    files = listing(home, digest)
    shots = store.catalogue.shots(campaign=name, limit=MOST_SHOTS)
    return (
        POSES not in files
        and not {CONTACTS, IMPACTS}.isdisjoint(files)
        and all(shot.results <= 1 for shot in shots)
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
        export_campaign(store, name, folder, say=lambda _text, _share: None)
        return gather(folder)[1]
