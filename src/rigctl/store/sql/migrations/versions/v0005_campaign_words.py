"""Notes and tags of campaigns."""

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"


def upgrade() -> None:
    """Make their tables; who changed them is in the audit of edits."""
    op.create_table(
        "campaign_notes",
        sa.Column("campaign", sa.Text, primary_key=True),
        sa.Column("note", sa.Text, nullable=False),
        sqlite_strict=True,
    )
    op.create_table(
        "campaign_tags",
        sa.Column("tag", sa.Text, primary_key=True),
        sa.Column("campaign", sa.Text, primary_key=True),
        sqlite_strict=True,
    )
