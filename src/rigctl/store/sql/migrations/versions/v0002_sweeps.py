"""Sweeps and their steps."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"

STEP_STATES = "'waiting', 'taken', 'stored', 'lost', 'not_fired', 'unknown', 'skipped'"


def upgrade() -> None:
    """Make the tables of sweeps."""
    op.create_table(
        "sweeps",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("id", sa.Text, nullable=False, unique=True),
        sa.Column("key", sa.Text, nullable=False, unique=True),
        sa.Column("body_hash", sa.Text, nullable=False),
        sa.Column("state", sa.Text, nullable=False),
        sa.Column("reason", sa.Text, nullable=False),
        sa.Column("form", sa.Text, nullable=False),
        sa.Column("rules", sa.Text, nullable=False),
        sa.Column("campaign", sa.Text),
        sa.Column("actor", sa.Text, nullable=False),
        sa.Column("accepted_at", sa.Text, nullable=False),
        sa.Column("ended_at", sa.Text),
        sa.CheckConstraint(
            "state IN ('running', 'paused', 'completed', 'aborted')", name="state_is_known"
        ),
        sqlite_strict=True,
    )
    op.create_table(
        "sweep_steps",
        sa.Column("sweep", sa.Integer, sa.ForeignKey("sweeps.number"), primary_key=True),
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("settings", sa.Text, nullable=False),
        sa.Column("state", sa.Text, nullable=False),
        sa.Column("attempt", sa.Integer, nullable=False),
        sa.Column("key", sa.Text, unique=True),
        sa.Column("shot", sa.Text, sa.ForeignKey("shots.id"), unique=True),
        sa.Column("taken_at", sa.Text),
        sa.Column("ended_at", sa.Text),
        sa.Column("failure", sa.Text),
        sa.CheckConstraint(f"state IN ({STEP_STATES})", name="state_is_known"),
        sqlite_strict=True,
    )
