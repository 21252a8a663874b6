"""From any earlier form of the catalogue to the present one, step by step, all or nothing."""

from rigctl.store.sql.migrations.upgrade import upgrade

__all__ = ["upgrade"]
