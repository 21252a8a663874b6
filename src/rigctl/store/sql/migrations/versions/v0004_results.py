"""The digest of each result's file."""

import sqlalchemy as sa
from alembic import op

from rigctl.store.sql.migrations.append_only import forbid_changes

revision = "0004"
down_revision = "0003"


def upgrade() -> None:
    """Make their table; files that were written before have no digest to be compared with."""
    op.create_table(
        "results",
        sa.Column("shot", sa.Integer, sa.ForeignKey("shots.number"), primary_key=True),
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("digest", sa.Text, nullable=False),
        sqlite_strict=True,
    )
    forbid_changes("results")
