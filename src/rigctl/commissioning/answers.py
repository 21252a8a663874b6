"""What people said of the steps: sealed with the key of the store's audit, and kept in it.

The record of all of it is a file with a signature, written and read here too.
"""

from __future__ import annotations

import hashlib
import json
import logging
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from rigctl.commissioning.step import Step
from rigctl.config import Configuration
from rigctl.errors import SettingsError, StoreError
from rigctl.store.edits import COMMISSIONING
from rigctl.store.integrity.seal import Seal, read_seal
from rigctl.store.store import Store

_log = logging.getLogger(__name__)

YES, NO, REWIRED = "yes", "no", "rewired"


@dataclass(frozen=True, slots=True)
class Answer:
    """One entry: the answer to a step, or that a part was rewired.

    Attributes
    ----------
    about
        The step, or the part.
    at
        UTC, ISO 8601.
    found
        What the daemon saw of its act; empty where it did nothing.
    configuration
        SHA-256 of the whole configuration.
    firmware
        What each device says of its firmware.
    marks
        SHA-256 of everything that the step says something about, by its name; see `marks_of`.
    """

    about: str
    answer: str
    at: str
    people: tuple[str, ...]
    actor: str
    found: str
    note: str
    configuration: str
    firmware: Mapping[str, str]
    marks: Mapping[str, str]


def marks_of(
    step: Step, configuration: Configuration, firmware: Mapping[str, str]
) -> dict[str, str]:
    """Return the digests of what a step depends on: sections of the configuration, firmware.

    A simulated rig has one more, so that no answer of a rehearsal counts for a real rig.
    """
    document = configuration.model_dump(mode="json")
    marks = {path: _digest(_at(document, path)) for path in step.sections}
    if configuration.simulation is not None:
        marks["simulation"] = _digest(True)
    if step.firmware:
        marks[f"firmware of the {step.part}"] = _digest(firmware.get(step.part, ""))
    return marks


class Answers:
    """The entries of a store, oldest first; one whose seal does not fit counts for nothing."""

    def __init__(self, store: Store) -> None:
        self._edits, self._path = store.edits, store.path
        seal = read_seal(store.path)
        if seal is None:
            raise StoreError("the key of the audit is missing", part=str(store.path))
        self._seal: Seal = seal
        self._entries = list(self._read())

    @property
    def entries(self) -> tuple[Answer, ...]:
        """All of them."""
        return tuple(self._entries)

    def add(self, answer: Answer) -> None:
        """Put an entry on disk; raise `StoreError`."""
        text = json.dumps({**asdict(answer), "seal": self.sign(asdict(answer))})
        self._edits.commissioning(answer.actor, answer.about, text)
        self._entries.append(answer)

    def sign(self, document: Mapping[str, object]) -> str:
        """Return the signature of a document: HMAC-SHA-256 with the key of the audit."""
        return signature(self._seal, document)

    def _read(self) -> Iterator[Answer]:
        for edit in self._edits.commissionings():
            fields = json.loads(edit.after or "{}")
            seal = fields.pop("seal", None)
            if seal != self.sign(fields):
                _log.error("%s of entry %d is not sealed by this store", COMMISSIONING, edit.number)
                continue
            yield Answer(**{**fields, "people": tuple(fields["people"])})


def signature(seal: Seal, document: Mapping[str, object]) -> str:
    """Return the signature of a document under a seal."""
    text = json.dumps(document, sort_keys=True, separators=(",", ":"))
    return seal.digest(COMMISSIONING, (text,))


def day_of(answer: Answer) -> str:
    """Return the day of an entry, UTC."""
    return f"{datetime.fromisoformat(answer.at):%Y-%m-%d}"


def _at(document: object, path: str) -> object:
    for word in path.split("."):
        document = document.get(word) if isinstance(document, dict) else None
    return document


def _digest(value: object) -> str:
    text = json.dumps(value, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def write_record(path: Path, document: Mapping[str, Any]) -> None:
    """Write a record; raise `StoreError` if the disk refuses."""
    try:
        path.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    except OSError as error:
        raise StoreError(
            f"the record cannot be written: {error.strerror}",
            part=str(path),
            todo="name a file that can be written",
        ) from error


def read_record(path: Path, store: Path) -> tuple[dict[str, Any], str, str]:
    """Return a record without its signature, that signature, and the one the store would give.

    Raises
    ------
    SettingsError
        The file is no record.
    StoreError
        The store's key is missing or cannot be read.
    """
    try:
        document = dict(json.loads(path.read_text(encoding="utf-8")))
        given = str(document.pop("signature"))
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise SettingsError(
            f"is no record of a commissioning: {error}", part=str(path), todo="name another file"
        ) from error
    seal = read_seal(store)
    if seal is None:
        raise StoreError(
            "no store with a key of the audit is here",
            part=str(store),
            todo="name with --config the configuration of the rig that wrote the record",
        )
    return document, given, signature(seal, document)
