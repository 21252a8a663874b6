"""What goes in and out over REST: strict requests, complete answers."""

from __future__ import annotations

import hashlib
from datetime import datetime
from typing import Literal, Self

from pydantic import BaseModel, Field

from rigctl.config.model import StrictModel
from rigctl.plain_text import MOST_TAGS, CampaignName, Line, Tag
from rigctl.rig.interlocks import Interlock
from rigctl.rig.states import RigState
from rigctl.rig.status import RigStatus, Transition
from rigctl.service.forms import Query, View
from rigctl.settings import ShotSettings
from rigctl.store import Fired, ShotRecord, ShotState


class ShotOrder(StrictModel):
    """Fire once with the settings that the token was given for."""

    arm_token: str = Field(min_length=1, max_length=200)
    campaign: CampaignName | None = None
    note: Line | None = None

    def digest(self) -> str:
        """Return the fingerprint that detects an idempotency key with another body."""
        return hashlib.sha256(self.model_dump_json().encode()).hexdigest()


class ReleaseOrder(StrictModel):
    """Reason of a person for releasing the latch of the rig."""

    reason: Line


class ExcludeOrder(StrictModel):
    """Why a shot is left out of every fit."""

    reason: Line


class NoteOrder(StrictModel):
    """New note of a shot or a campaign; null removes the note."""

    note: Line | None


class TagsOrder(StrictModel):
    """The tags that a shot or a campaign is to have, in the place of those it has."""

    tags: list[Tag] = Field(max_length=MOST_TAGS)


class ShotQuery(Query):
    """Which shots to list; `after` is the id of the last shot of the page before."""

    campaign: CampaignName | None = None
    state: ShotState | None = None
    excluded: bool | None = None
    tag: Tag | None = None
    limit: int = Field(default=100, ge=1, le=500)
    after: str | None = Field(default=None, pattern=r"^(\d{8}|i\d{4,8})-\d{6,12}$")


class FrameQuery(Query):
    """How to draw a frame: as it is, or with what the analysis found drawn over it."""

    overlay: Literal["none", "outlines"] = "none"


class InterlockView(View):
    """One named condition that must hold before anything fires, as it was last read."""

    name: str
    holds: bool
    value: float | str
    limit: str
    unit: str
    age_s: float = Field(description="how old the reading is, in seconds")
    source: str
    todo: str = Field(description="what the operator does when it refuses")

    @classmethod
    def of(cls, interlock: Interlock, now: float) -> Self:
        """Return a condition as REST shows it; `now` is the monotonic time its age counts to."""
        return cls.showing(interlock, age_s=interlock.age_s(now))


class RigView(View):
    """State of the rig at one moment, and whether it is simulated. Times are UTC."""

    name: str
    apparatus: str
    simulated: bool
    state: RigState
    since: datetime
    reason: str
    settings: ShotSettings | None = Field(description="those of the last arm request")
    expires_at: datetime | None = Field(description="when the live arm token expires")
    interlocks: list[InterlockView]
    running: str | None = Field(description="the shot in progress")
    last_shot: str | None
    latch_reason: str | None = Field(description="why a person has to release the rig")
    warnings: list[str]

    @classmethod
    def of(cls, status: RigStatus) -> Self:
        """Return a snapshot as REST shows it."""
        return cls.showing(
            status,
            expires_at=status.token_expires_at,
            interlocks=[InterlockView.of(each, status.read_at) for each in status.interlocks],
            last_shot=status.last_shot.id if status.last_shot else None,
        )


class RigEvent(View):
    """The rig went into a state; `before` and `actor` are null in the first event, the present."""

    state: RigState
    before: RigState | None
    at: datetime
    actor: str | None
    reason: str
    shot: str | None

    @classmethod
    def of(cls, step: Transition) -> Self:
        """Return a transition as an event."""
        return cls.showing(step, state=step.after)

    @classmethod
    def present(cls, status: RigStatus) -> Self:
        """Return the present state as an event."""
        return cls(
            state=status.state,
            before=None,
            at=status.since,
            actor=None,
            reason=status.reason,
            shot=status.running,
        )


class ArmView(BaseModel):
    """The token that fires once, when it expires (UTC), and warnings before firing."""

    arm_token: str
    expires_at: datetime
    expires_in_s: float
    warnings: list[str]


class ShotAccepted(BaseModel):
    """The stored answer of an idempotency key: the shot it made and the state of that shot."""

    shot: str
    state: ShotState


class ShotView(View):
    """One shot. Times are UTC; a field that is not known is null.

    `outcome` is the state in which the rig left the shot, null while it runs; `fired`: whether the
    spheres flew, as far as it is known; `lost` counts pictures the camera skipped.
    """

    shot: str
    state: ShotState
    outcome: ShotState | None
    fired: Fired
    settings: ShotSettings | None = Field(description="null: imported, and not all stated")
    campaign: str | None
    note: str | None
    actor: str
    simulated: bool
    configuration: str = Field(description="SHA-256 of the configuration it was fired under")
    accepted_at: datetime
    fired_at: datetime | None
    ended_at: datetime | None
    frames: int | None
    lost: int | None
    failure: str | None
    failure_code: str | None
    results: int = Field(description="how many measurements of it are stored")
    excluded: str | None = Field(description="why it is left out of every fit; null: it counts")
    tags: list[str]
    imported_as: int | None = Field(description="its number in the folder it came from")

    @classmethod
    def of(cls, record: ShotRecord) -> Self:
        """Return a record as REST shows it."""
        return cls.showing(record, shot=record.id)


class ShotList(BaseModel):
    """Shots, oldest first; `next` is the `after` of the page that follows, null at the end."""

    shots: list[ShotView]
    next: str | None
