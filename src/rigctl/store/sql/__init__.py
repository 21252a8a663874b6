"""The catalogue's tables, their transactions and versions, in SQLite or PostgreSQL."""
