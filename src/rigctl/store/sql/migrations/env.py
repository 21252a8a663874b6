"""What Alembic runs for each command; the connection is the caller's, open and in a transaction."""

from alembic import context

from rigctl.store.sql.schema import metadata

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=metadata,
    transactional_ddl=True,
)
with context.begin_transaction():
    context.run_migrations()
