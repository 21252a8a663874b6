"""What a key that nobody knows may have been meant to be."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any, Literal, get_args, get_origin


@dataclass(frozen=True, slots=True)
class _Section:
    """One form of a section: its fields by name, as annotated."""

    fields: dict[str, Any]

    def is_chosen_by(self, tag: str) -> bool:
        """Say whether one of its fields is always this text, as the driver of a device is."""
        return any(tag in _texts(kind) for kind in self.fields.values())


def meant(form: type, place: tuple[int | str, ...], present: Collection[str]) -> str | None:
    """Return the key that an unknown one is a slip of; None where none is like it.

    Parameters
    ----------
    form
        Model of the whole document.
    place
        Where the unknown key is, as pydantic names it: with the tag of a section that has several
        forms, and numbers in lists.
    present
        Keys of the same section, which are not meant.
    """
    *path, key = place
    sections = list(_sections(form))
    for step in path:
        if isinstance(step, int):
            continue
        inner = [each.fields[step] for each in sections if step in each.fields]
        chosen = [each for each in sections if each.is_chosen_by(step)]
        sections = [found for kind in inner for found in _sections(kind)] if inner else chosen
    names = {name for each in sections for name in each.fields} - set(present)
    return next(iter(get_close_matches(str(key), sorted(names), n=1)), None)


def _sections(kind: object) -> Iterator[_Section]:
    """Give every form of section within an annotation: models in unions, lists, annotations."""
    fields = getattr(kind, "__pydantic_fields__", None)
    if fields is not None:
        yield _Section({name: field.annotation for name, field in fields.items()})
        return
    for inner in () if get_origin(kind) is Literal else get_args(kind):
        yield from _sections(inner)


def _texts(kind: object) -> tuple[object, ...]:
    return get_args(kind) if get_origin(kind) is Literal else ()
