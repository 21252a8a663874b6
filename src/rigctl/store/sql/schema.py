"""Tables of the catalogue, and the version that this program can read."""

from __future__ import annotations

from enum import StrEnum

from sqlalchemy import (
    REAL,
    CheckConstraint,
    Column,
    Dialect,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    Table,
    Text,
    TypeDecorator,
)

from rigctl.store.states import Fired, ShotState
from rigctl.store.sweep_states import StepState, SweepState

_ESCAPED = (("\x01", "\x01\x01"), ("\x00", "\x01\x02"))


class AnyText(TypeDecorator[str]):
    """Text that may hold a NUL: PostgreSQL has none, and an audit must lose nothing.

    There a NUL is written as 01 02 and an 01 as 01 01; SQLite takes text as it is.
    """

    impl = Text
    cache_ok = True

    def process_bind_param(self, value: str | None, dialect: Dialect) -> str | None:
        """Return what is written."""
        if value is None or dialect.name != "postgresql":
            return value
        for character, written in _ESCAPED:
            value = value.replace(character, written)
        return value

    def process_result_value(self, value: str | None, dialect: Dialect) -> str | None:
        """Return what was written."""
        if value is None or dialect.name != "postgresql" or "\x01" not in value:
            return value
        parts = iter(value)
        return "".join(self._read(next(parts)) if c == "\x01" else c for c in parts)

    @staticmethod
    def _read(escaped: str) -> str:
        return "\x00" if escaped == "\x02" else "\x01"


SCHEMA_VERSION = 6
"""Number of the last migration; a catalogue carries its own as `user_version`."""

metadata = MetaData()


def _one_of(column: str, words: type[StrEnum]) -> CheckConstraint:
    listed = ", ".join(f"'{word}'" for word in words)
    return CheckConstraint(f"{column} IN ({listed})", name=f"{column}_is_known")


shots = Table(
    "shots",
    metadata,
    Column("number", Integer, primary_key=True),
    Column("id", AnyText, nullable=False, unique=True),
    Column("state", AnyText, nullable=False),
    Column("outcome", AnyText),
    Column("fired", AnyText, nullable=False),
    Column("settings", AnyText, nullable=False),
    Column("campaign", AnyText),
    Column("note", AnyText),
    Column("actor", AnyText, nullable=False),
    Column("simulated", Integer, nullable=False),
    Column("configuration", AnyText, nullable=False),
    Column("accepted_at", AnyText, nullable=False),
    Column("fired_at", AnyText),
    Column("ended_at", AnyText),
    Column("frames", Integer),
    Column("lost", Integer),
    Column("failure", AnyText),
    Column("failure_code", AnyText),
    Column("results", Integer, nullable=False, server_default="0"),
    Column("excluded", AnyText),
    Column("imported_as", Integer),
    Column("manifest", AnyText),
    _one_of("state", ShotState),
    _one_of("fired", Fired),
    Index("ix_shots_state", "state", "number"),
    Index("ix_shots_campaign", "campaign", "number"),
    Index("ix_shots_campaign_state", "campaign", "state", "number", "accepted_at", "excluded"),
    sqlite_strict=True,
)

shot_tags = Table(
    "shot_tags",
    metadata,
    Column("tag", AnyText, primary_key=True),
    Column("shot", Integer, ForeignKey("shots.number"), primary_key=True),
    Index("ix_shot_tags_shot", "shot"),
    sqlite_strict=True,
)

campaign_notes = Table(
    "campaign_notes",
    metadata,
    Column("campaign", AnyText, primary_key=True),
    Column("note", AnyText, nullable=False),
    sqlite_strict=True,
)

campaign_tags = Table(
    "campaign_tags",
    metadata,
    Column("tag", AnyText, primary_key=True),
    Column("campaign", AnyText, primary_key=True),
    sqlite_strict=True,
)

results = Table(
    "results",
    metadata,
    Column("shot", Integer, ForeignKey("shots.number"), primary_key=True),
    Column("number", Integer, primary_key=True),
    Column("digest", AnyText, nullable=False),
    sqlite_strict=True,
)

imports = Table(
    "imports",
    metadata,
    Column("number", Integer, primary_key=True),
    Column("campaign", AnyText, nullable=False, unique=True),
    Column("digest", AnyText, nullable=False),
    sqlite_strict=True,
)

edits = Table(
    "edits",
    metadata,
    Column("number", Integer, primary_key=True),
    Column("at", AnyText, nullable=False),
    Column("actor", AnyText, nullable=False),
    Column("act", AnyText, nullable=False),
    Column("subject", AnyText, nullable=False),
    Column("before", AnyText),
    Column("after", AnyText),
    Column("digest", AnyText, nullable=False),
    sqlite_strict=True,
)

idempotency_keys = Table(
    "idempotency_keys",
    metadata,
    Column("key", AnyText, primary_key=True),
    Column("body_hash", AnyText, nullable=False),
    Column("shot", Integer, ForeignKey("shots.number"), nullable=False),
    sqlite_strict=True,
)

transitions = Table(
    "transitions",
    metadata,
    Column("number", Integer, primary_key=True),
    Column("at", AnyText, nullable=False),
    Column("before", AnyText, nullable=False),
    Column("after", AnyText, nullable=False),
    Column("actor", AnyText, nullable=False),
    Column("reason", AnyText, nullable=False),
    Column("shot", AnyText, ForeignKey("shots.id")),
    Column("digest", AnyText, nullable=False),
    sqlite_strict=True,
)

sweeps = Table(
    "sweeps",
    metadata,
    Column("number", Integer, primary_key=True),
    Column("id", AnyText, nullable=False, unique=True),
    Column("key", AnyText, nullable=False, unique=True),
    Column("body_hash", AnyText, nullable=False),
    Column("state", AnyText, nullable=False),
    Column("reason", AnyText, nullable=False),
    Column("form", AnyText, nullable=False),
    Column("rules", AnyText, nullable=False),
    Column("campaign", AnyText),
    Column("actor", AnyText, nullable=False),
    Column("accepted_at", AnyText, nullable=False),
    Column("ended_at", AnyText),
    _one_of("state", SweepState),
    sqlite_strict=True,
)

sweep_steps = Table(
    "sweep_steps",
    metadata,
    Column("sweep", Integer, ForeignKey("sweeps.number"), primary_key=True),
    Column("number", Integer, primary_key=True),
    Column("settings", AnyText, nullable=False),
    Column("state", AnyText, nullable=False),
    Column("attempt", Integer, nullable=False),
    Column("key", AnyText, unique=True),
    Column("shot", AnyText, ForeignKey("shots.id"), unique=True),
    Column("taken_at", AnyText),
    Column("ended_at", AnyText),
    Column("failure", AnyText),
    _one_of("state", StepState),
    sqlite_strict=True,
)

ledger = Table(
    "ledger",
    metadata,
    Column("number", Integer, primary_key=True),
    Column("about", AnyText, nullable=False),
    Column("row", AnyText, nullable=False),
    Column("content", AnyText),
    Column("digest", AnyText, nullable=False),
    sqlite_strict=True,
)

probe = Table(
    "probe",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("monotonic_s", REAL, nullable=False),
    sqlite_strict=True,
)
