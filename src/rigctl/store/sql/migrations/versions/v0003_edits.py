"""Exclusions, tags, imported campaigns, and the audit of what people changed afterwards."""

import sqlalchemy as sa
from alembic import op

from rigctl.store.sql.migrations.append_only import forbid_changes

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    """Add them, and the indexes that a filtered page of a large catalogue needs."""
    op.add_column("shots", sa.Column("excluded", sa.Text))
    op.add_column("shots", sa.Column("imported_as", sa.Integer))
    op.add_column("shots", sa.Column("manifest", sa.Text))
    op.drop_index("ix_shots_state", "shots")
    op.drop_index("ix_shots_campaign", "shots")
    op.create_index("ix_shots_state", "shots", ["state", "number"])
    op.create_index("ix_shots_campaign", "shots", ["campaign", "number"])
    # Its last two columns let campaigns be counted without a look at their shots.
    counted = ["campaign", "state", "number", "accepted_at", "excluded"]
    op.create_index("ix_shots_campaign_state", "shots", counted)
    op.create_table(
        "shot_tags",
        sa.Column("tag", sa.Text, primary_key=True),
        sa.Column("shot", sa.Integer, sa.ForeignKey("shots.number"), primary_key=True),
        sqlite_strict=True,
    )
    op.create_index("ix_shot_tags_shot", "shot_tags", ["shot"])
    op.create_table(
        "imports",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("campaign", sa.Text, nullable=False, unique=True),
        sa.Column("digest", sa.Text, nullable=False),
        sqlite_strict=True,
    )
    op.create_table(
        "edits",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("at", sa.Text, nullable=False),
        sa.Column("actor", sa.Text, nullable=False),
        sa.Column("act", sa.Text, nullable=False),
        sa.Column("subject", sa.Text, nullable=False),
        sa.Column("before", sa.Text),
        sa.Column("after", sa.Text),
        sa.Column("digest", sa.Text, nullable=False),
        sqlite_strict=True,
    )
    forbid_changes("edits")
