"""What survives: the catalogue of shots and sweeps, and one folder for each shot."""

from rigctl.store.campaigns import CampaignRecord
from rigctl.store.catalogue import Change
from rigctl.store.reading import StoreReader, reading
from rigctl.store.records import Edit, JournalEntry, NewShot, ShotRecord
from rigctl.store.states import RUNNING, Fired, ShotState
from rigctl.store.store import Store
from rigctl.store.sweep_records import NewSweep, StepRecord, SweepRecord
from rigctl.store.sweep_states import StepState, SweepState

__all__ = [
    "RUNNING",
    "CampaignRecord",
    "Change",
    "Edit",
    "Fired",
    "JournalEntry",
    "NewShot",
    "NewSweep",
    "ShotRecord",
    "ShotState",
    "StepRecord",
    "StepState",
    "Store",
    "StoreReader",
    "SweepRecord",
    "SweepState",
    "reading",
]
