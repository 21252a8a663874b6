"""Text as Python has it, in a column of either kind of catalogue."""

from __future__ import annotations

from sqlalchemy import Dialect, Text, TypeDecorator

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
