"""Tables of the catalogue, and the version that this program can read."""

from __future__ import annotations

from enum import StrEnum

from sqlalchemy import (
    REAL,
    CheckConstraint,
    Column,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    Table,
    Text,
)

from rigctl.store.states import Fired, ShotState
from rigctl.store.sweep_states import StepState, SweepState

SCHEMA_VERSION = 3
"""Number of the last migration; a catalogue carries its own as `user_version`."""

metadata = MetaData()


def _one_of(column: str, words: type[StrEnum]) -> CheckConstraint:
    listed = ", ".join(f"'{word}'" for word in words)
    return CheckConstraint(f"{column} IN ({listed})", name=f"{column}_is_known")


shots = Table(
    "shots",
    metadata,
    Column("number", Integer, primary_key=True),
    Column("id", Text, nullable=False, unique=True),
    Column("state", Text, nullable=False),
    Column("outcome", Text),
    Column("fired", Text, nullable=False),
    Column("settings", Text, nullable=False),
    Column("campaign", Text),
    Column("note", Text),
    Column("actor", Text, nullable=False),
    Column("simulated", Integer, nullable=False),
    Column("configuration", Text, nullable=False),
    Column("accepted_at", Text, nullable=False),
    Column("fired_at", Text),
    Column("ended_at", Text),
    Column("frames", Integer),
    Column("lost", Integer),
    Column("failure", Text),
    Column("failure_code", Text),
    Column("results", Integer, nullable=False, server_default="0"),
    Column("excluded", Text),
    Column("imported_as", Integer),
    Column("manifest", Text),
    _one_of("state", ShotState),
    _one_of("fired", Fired),
    Index("ix_shots_state", "state", "number"),
    Index("ix_shots_campaign", "campaign", "number"),
    Index("ix_shots_campaign_state", "campaign", "state", "number"),
    sqlite_strict=True,
)

shot_tags = Table(
    "shot_tags",
    metadata,
    Column("tag", Text, primary_key=True),
    Column("shot", Integer, ForeignKey("shots.number"), primary_key=True),
    Index("ix_shot_tags_shot", "shot"),
    sqlite_strict=True,
)

imports = Table(
    "imports",
    metadata,
    Column("number", Integer, primary_key=True),
    Column("campaign", Text, nullable=False, unique=True),
    Column("digest", Text, nullable=False),
    sqlite_strict=True,
)

edits = Table(
    "edits",
    metadata,
    Column("number", Integer, primary_key=True),
    Column("at", Text, nullable=False),
    Column("actor", Text, nullable=False),
    Column("act", Text, nullable=False),
    Column("subject", Text, nullable=False),
    Column("before", Text),
    Column("after", Text),
    Column("digest", Text, nullable=False),
    sqlite_strict=True,
)

idempotency_keys = Table(
    "idempotency_keys",
    metadata,
    Column("key", Text, primary_key=True),
    Column("body_hash", Text, nullable=False),
    Column("shot", Integer, ForeignKey("shots.number"), nullable=False),
    sqlite_strict=True,
)

transitions = Table(
    "transitions",
    metadata,
    Column("number", Integer, primary_key=True),
    Column("at", Text, nullable=False),
    Column("before", Text, nullable=False),
    Column("after", Text, nullable=False),
    Column("actor", Text, nullable=False),
    Column("reason", Text, nullable=False),
    Column("shot", Text, ForeignKey("shots.id")),
    Column("digest", Text, nullable=False),
    sqlite_strict=True,
)

sweeps = Table(
    "sweeps",
    metadata,
    Column("number", Integer, primary_key=True),
    Column("id", Text, nullable=False, unique=True),
    Column("key", Text, nullable=False, unique=True),
    Column("body_hash", Text, nullable=False),
    Column("state", Text, nullable=False),
    Column("reason", Text, nullable=False),
    Column("form", Text, nullable=False),
    Column("rules", Text, nullable=False),
    Column("campaign", Text),
    Column("actor", Text, nullable=False),
    Column("accepted_at", Text, nullable=False),
    Column("ended_at", Text),
    _one_of("state", SweepState),
    sqlite_strict=True,
)

sweep_steps = Table(
    "sweep_steps",
    metadata,
    Column("sweep", Integer, ForeignKey("sweeps.number"), primary_key=True),
    Column("number", Integer, primary_key=True),
    Column("settings", Text, nullable=False),
    Column("state", Text, nullable=False),
    Column("attempt", Integer, nullable=False),
    Column("key", Text, unique=True),
    Column("shot", Text, ForeignKey("shots.id"), unique=True),
    Column("taken_at", Text),
    Column("ended_at", Text),
    Column("failure", Text),
    _one_of("state", StepState),
    sqlite_strict=True,
)

probe = Table(
    "probe",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("monotonic_s", REAL, nullable=False),
    sqlite_strict=True,
)
