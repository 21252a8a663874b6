"""The ledger: every change of a row, in a chain that cannot be continued without its key."""

import sqlalchemy as sa
from alembic import op

from rigctl.store.sql.migrations.append_only import forbid_changes

revision = "0006"
down_revision = "0005"


def upgrade() -> None:
    """Make its table; the store writes the rows that there are as its first entries."""
    op.create_table(
        "ledger",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("about", sa.Text, nullable=False),
        sa.Column("row", sa.Text, nullable=False),
        sa.Column("content", sa.Text),
        sa.Column("digest", sa.Text, nullable=False),
        sqlite_strict=True,
    )
    forbid_changes("ledger")
