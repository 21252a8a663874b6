"""What survives: the catalogue of shots and one folder for each shot."""

from rigctl.store.campaigns import CampaignRecord
from rigctl.store.catalogue import Change
from rigctl.store.listeners import Listeners
from rigctl.store.reading import StoreReader, reading
from rigctl.store.records import JournalEntry, NewShot, ShotRecord
from rigctl.store.states import RUNNING, Fired, ShotState
from rigctl.store.store import Store

__all__ = [
    "RUNNING",
    "CampaignRecord",
    "Change",
    "Fired",
    "JournalEntry",
    "Listeners",
    "NewShot",
    "ShotRecord",
    "ShotState",
    "Store",
    "StoreReader",
    "reading",
]
