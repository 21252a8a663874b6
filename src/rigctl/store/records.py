"""Rows of the catalogue as unchangeable snapshots."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from rigctl.errors import StoreError
from rigctl.plain_text import require_plain
from rigctl.settings import ShotSettings
from rigctl.store.states import Fired, ShotState


@dataclass(frozen=True, slots=True)
class NewShot:
    """What is known of a shot when it is accepted; `accepted_at` is UTC and dates its name."""

    settings: ShotSettings
    campaign: str | None
    note: str | None
    actor: str
    simulated: bool
    configuration: str
    accepted_at: datetime

    def __post_init__(self) -> None:
        """Refuse a note, campaign or actor that is no plain line."""
        for part in ("note", "campaign", "actor"):
            require_plain(getattr(self, part), part)


@dataclass(frozen=True, slots=True)
class Request:
    """Idempotency key of the request that made a shot, and the SHA-256 of the request's body."""

    key: str
    body_hash: str


@dataclass(frozen=True, slots=True)
class ShotRecord:
    """One shot as the catalogue has it.

    Attributes
    ----------
    id, number
        `YYYYMMDD-NNNNNN` (UTC date and number); the number rises through restarts and is the
        sequence number that the trigger is given.
    state, outcome
        State of the shot, and the state in which the rig left it (None: still running).
        The outcome is the stored answer of its idempotency key and never changes.
    settings
        None: it was imported, and they are not all stated.
    configuration
        SHA-256 of the configuration it was fired under; empty where that is not known.
    frames, lost
        Frames stored, and pictures that the source skipped; None before `stored`.
    failure, failure_code
        Why it did not come through, in one sentence, with the error's stable code.
    results
        How many results its folder holds.
    excluded
        Why a person left it out of every fit; None: it counts.
    tags
        Words a person gave it, in alphabetical order.
    imported_as
        Its number in the exchange folder it came from; None: it was fired here.
    manifest
        SHA-256 of its manifest, which holds that of its frames; None: no frames are stored, or
        they were before this was noted.
    """

    id: str
    number: int
    state: ShotState
    outcome: ShotState | None
    fired: Fired
    settings: ShotSettings | None
    campaign: str | None
    note: str | None
    actor: str
    simulated: bool
    configuration: str
    accepted_at: datetime
    fired_at: datetime | None
    ended_at: datetime | None
    frames: int | None
    lost: int | None
    failure: str | None
    failure_code: str | None
    results: int
    excluded: str | None = None
    tags: tuple[str, ...] = ()
    imported_as: int | None = None
    manifest: str | None = None

    @property
    def is_without_frames(self) -> bool:
        """Whether it was imported with poses or tables alone, without frames to analyse."""
        return self.imported_as is not None and self.frames is None

    @property
    def ordered(self) -> ShotSettings:
        """The settings of a shot that this rig fires or has fired.

        Raises
        ------
        StoreError
            It was imported without them.
        """
        if self.settings is None:
            raise StoreError("states no settings", part=f"shot {self.id}", todo="fire a fresh shot")
        return self.settings


@dataclass(frozen=True, slots=True)
class Edit:
    """One change that a person made to what is known of a shot or a campaign.

    Attributes
    ----------
    act
        `excluded`, `included`, `noted` or `tagged` of a shot; `imported`, `campaign noted` or
        `campaign tagged` of a campaign; `key added` or `key revoked` of a named key; `wrong keys`
        of an address; `recovered` of the catalogue.
    subject
        Name of the shot, of the campaign or of the key; the address.
    before, after
        Values before and after the edit; tags are joined by commas.
    digest
        As that of a `JournalEntry`.
    """

    number: int
    at: datetime
    actor: str
    act: str
    subject: str
    before: str | None
    after: str | None
    digest: str


@dataclass(frozen=True, slots=True)
class JournalEntry:
    """One transition of the rig: who moved it from where to where, when (UTC) and why.

    `digest` closes the entry: the SHA-256 of the entry before it and of all its own fields.
    """

    number: int
    at: datetime
    before: str
    after: str
    actor: str
    reason: str
    shot: str | None
    digest: str
