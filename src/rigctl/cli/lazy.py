"""Groups of commands that are loaded when they are called, so that --help answers at once."""

from __future__ import annotations

import gc
import importlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self, TypeAlias

import typer
from typer.core import TyperGroup

Internal: TypeAlias = Any
"""Types of Typer's that it does not publish: context, formatter, command."""


@dataclass(frozen=True, slots=True)
class Command:
    """A command: its function as `module:function` below this package, and its line of help."""

    function: str
    help: str


@dataclass(frozen=True, slots=True)
class Group:
    """Commands behind one word.

    Attributes
    ----------
    otherwise
        The command that takes whatever names none of them.
    """

    help: str
    commands: Mapping[str, Command]
    otherwise: str | None = None


class LazyGroup(TyperGroup):
    """Commands of a table; the module of one is loaded when it is called or asked for its help."""

    _table: Mapping[str, Command | Group]
    _otherwise: str | None = None

    def holding(self, table: Mapping[str, Command | Group], otherwise: str | None = None) -> Self:
        """Take the commands of a table, and return the group itself."""
        self._table, self._otherwise = table, otherwise
        names: dict[str, Any] = dict.fromkeys(table)
        self.commands = names
        return self

    def get_command(self, ctx: Internal, cmd_name: str) -> Internal:
        """Return the command of a name, loaded; None where there is none."""
        if cmd_name not in self._table:
            return None
        entry = self._table[cmd_name]
        if isinstance(entry, Group):
            group = LazyGroup(
                name=cmd_name, help=entry.help, no_args_is_help=True, rich_markup_mode=None
            )
            return group.holding(entry.commands, entry.otherwise)
        module, _, function = entry.function.partition(":")
        # What is loaded stays: to look for garbage in it takes a tenth of the time.
        gc.disable()
        try:
            found = getattr(importlib.import_module(f"{__package__}.{module}"), function)
        finally:
            gc.enable()
        alone = typer.Typer(
            add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False
        )
        alone.command(cmd_name, help=entry.help)(found)
        return typer.main.get_command(alone)

    def format_commands(self, ctx: Internal, formatter: Internal) -> None:
        """Write names and lines of help, which the table has without loading a command."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, entry.help) for name, entry in self._table.items()])

    def parse_args(self, ctx: Internal, args: list[str]) -> list[str]:
        """Let the one that takes all the rest have what names no command."""
        if args and self._otherwise and args[0] not in self._table and args[0] != "--help":
            args = [self._otherwise, *args]
        return super().parse_args(ctx, args)
