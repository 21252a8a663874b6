"""Shots, their idempotency keys, the audit, and the row that proves commits."""

import sqlalchemy as sa
from alembic import op

from rigctl.store.sql.migrations.append_only import forbid_changes

revision = "0001"
down_revision = None

SHOT_STATES = (
    "'accepted', 'firing', 'capturing', 'stored', 'analysing', 'analysed', 'refused', 'misfire', "
    "'unknown_outcome', 'aborted', 'interrupted'"
)


def upgrade() -> None:
    """Make the tables of the first catalogues."""
    op.create_table(
        "shots",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("id", sa.Text, nullable=False, unique=True),
        sa.Column("state", sa.Text, nullable=False, index=True),
        sa.Column("outcome", sa.Text),
        sa.Column("fired", sa.Text, nullable=False),
        sa.Column("settings", sa.Text, nullable=False),
        sa.Column("campaign", sa.Text, index=True),
        sa.Column("note", sa.Text),
        sa.Column("actor", sa.Text, nullable=False),
        sa.Column("simulated", sa.Integer, nullable=False),
        sa.Column("configuration", sa.Text, nullable=False),
        sa.Column("accepted_at", sa.Text, nullable=False),
        sa.Column("fired_at", sa.Text),
        sa.Column("ended_at", sa.Text),
        sa.Column("frames", sa.Integer),
        sa.Column("lost", sa.Integer),
        sa.Column("failure", sa.Text),
        sa.Column("failure_code", sa.Text),
        sa.Column("results", sa.Integer, nullable=False, server_default="0"),
        sa.CheckConstraint(f"state IN ({SHOT_STATES})", name="state_is_known"),
        sa.CheckConstraint("fired IN ('no', 'yes', 'unknown')", name="fired_is_known"),
        sqlite_strict=True,
    )
    op.create_table(
        "idempotency_keys",
        sa.Column("key", sa.Text, primary_key=True),
        sa.Column("body_hash", sa.Text, nullable=False),
        sa.Column("shot", sa.Integer, sa.ForeignKey("shots.number"), nullable=False),
        sqlite_strict=True,
    )
    op.create_table(
        "transitions",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("at", sa.Text, nullable=False),
        sa.Column("before", sa.Text, nullable=False),
        sa.Column("after", sa.Text, nullable=False),
        sa.Column("actor", sa.Text, nullable=False),
        sa.Column("reason", sa.Text, nullable=False),
        sa.Column("shot", sa.Text, sa.ForeignKey("shots.id")),
        sa.Column("digest", sa.Text, nullable=False),
        sqlite_strict=True,
    )
    op.create_table(
        "probe",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("monotonic_s", sa.REAL, nullable=False),
        sqlite_strict=True,
    )
    forbid_changes("transitions")
