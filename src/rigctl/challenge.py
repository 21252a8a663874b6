"""`rigctl challenge`: a campaign that hides an effect, the user's answer, and the truth.

The campaign comes from whatever `MAKER` names; what passes between the two is the folder alone.
"""

from __future__ import annotations

import base64
import binascii
import hashlib
import importlib
import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Literal, Protocol, TypeVar, cast

from pydantic import BaseModel, Field, ValidationError

from rigctl.config.model import StrictModel
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError, NotFoundError, RefusedError, SettingsError, StoreError

MAKER = "simulators.challenge:new_challenge"
"""Module and function that make a challenge, loaded by name: no import of the simulators."""

SALT_BYTES = 16
PUBLIC, SEALED, ANSWER = "challenge.json", "sealed.txt", "answer.json"
ALONE = ("none", "unexplained")
"""Answers that name no effect, and stand alone."""

Model = TypeVar("Model", bound=BaseModel)
Outcome = Literal["right", "alias", "partly", "wrong"]


class Maker(Protocol):
    """What `MAKER` names."""

    def __call__(
        self, folder: Path, *, seed: int | None, strength: str, shots: int, from_frames: bool
    ) -> None:
        """Write a campaign with its seal; raise ValueError for what cannot be."""


class Challenge(StrictModel):
    """challenge.json: fingerprint of the sealed label, and the names a label may hold."""

    format: Literal[1]
    sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    names: list[str]


Law = tuple[str, str, str]
"""Slot, argument and shape: what depends on what, and how."""
OF_A_LAW = ("slot", "argument", "shape")


class HiddenEffect(StrictModel):
    """One effect of the label: its size, in its unit, and the meaning of the number.

    `law` is what depends on what, and how, in what no catalogue holds.
    """

    effect: str
    amplitude: float
    unit: str
    meaning: str
    law: list[str] | None = None


class Label(StrictModel):
    """The truth: the right answer, its aliases by name, and further effects that are accepted.

    `world` is what the simulated world has beside hard spheres, whatever is hidden in it.
    """

    answer: list[str]
    effects: list[HiddenEffect]
    like: dict[str, list[str]]
    beside: list[str]
    world: list[str] = Field(default_factory=list)


class Answer(StrictModel):
    """answer.json: what the user committed to; `law` beside `unexplained`."""

    answer: Annotated[list[str], Field(min_length=1)]
    law: Annotated[list[str], Field(min_length=3, max_length=3)] | None = None


def new(
    folder: Path, *, seed: int | None, strength: str, shots: int, from_frames: bool = False
) -> None:
    """Write a campaign of poses, or of frames, that hides something, with its seal.

    Raises
    ------
    SettingsError
        The folder holds something, or a number is out of range.
    StoreError
        The folder cannot be written.
    """
    module, _, name = MAKER.partition(":")
    # An object loaded by name has no static type.
    make = cast("Maker", getattr(importlib.import_module(module), name))
    try:
        make(folder, seed=seed, strength=strength, shots=shots, from_frames=from_frames)
    except ValueError as error:
        raise SettingsError(str(error), part="challenge new") from error
    except OSError as error:
        raise _unwritable(folder, error) from error


def commit(folder: Path, answer: str, *, known: Sequence[str], law: Law | None = None) -> list[str]:
    """Write the answer, once and for all, and return it as a list of names.

    Parameters
    ----------
    answer
        Names separated by commas, or `none`, or `unexplained`.
    known
        Names that an answer may hold besides those of the challenge.
    law
        Slot, argument and shape of what no catalogue holds, beside `unexplained`.

    Raises
    ------
    NotFoundError
        The folder is no challenge, or no effect has that name.
    AnalysisInputError
        challenge.json is damaged.
    SettingsError
        A name stands twice, or beside `none` or `unexplained`; or a law beside another answer.
    RefusedError
        There is an answer already.
    StoreError
        The answer cannot be written.
    """
    names = _names(answer, {*_challenge(folder).names, *known, *ALONE})
    if law is not None and names != ["unexplained"]:
        raise SettingsError(
            "a law is an answer where the catalogue holds none",
            part="--law",
            value=repr(" ".join(law)),
            todo="give it beside --answer unexplained",
        )
    stated = Answer(answer=names, law=None if law is None else list(law))
    text = stated.model_dump_json(indent=1, exclude_none=True) + "\n"
    draft = folder / f"{ANSWER}.{os.getpid()}"
    try:
        draft.write_text(text, encoding="utf-8")
        # A link, unlike a rename, never replaces what is there, and is whole or absent.
        os.link(draft, folder / ANSWER)
    except FileExistsError as error:
        raise RefusedError(
            "an answer stands and is never changed",
            part=str(folder / ANSWER),
            todo="reveal, and take another challenge",
        ) from error
    except OSError as error:
        raise _unwritable(folder, error) from error
    finally:
        draft.unlink(missing_ok=True)
    return names


def reveal(folder: Path) -> tuple[Label, list[str], Outcome]:
    """Open the seal of a challenge that was answered: the truth, the answer, and how they agree.

    Raises
    ------
    NotFoundError
        The folder is no challenge.
    RefusedError
        No answer was committed, or the label is not the one that was sealed.
    AnalysisInputError
        A file is damaged.
    """
    challenge = _challenge(folder)
    if not (folder / ANSWER).exists():
        raise RefusedError(
            "no answer was committed",
            part=str(folder),
            todo=f"commit first: rigctl challenge commit {folder} --answer NAME",
        )
    given = _read(folder / ANSWER, Answer).answer
    label = _opened(folder / SEALED, challenge.sha256)
    return label, given, judge(label, given)


def label_of(folder: Path) -> Label:
    """Return the truth of a challenge that may not be answered yet; hints are made of it alone.

    Raises
    ------
    NotFoundError, RefusedError, AnalysisInputError
        As `reveal`.
    """
    return _opened(folder / SEALED, _challenge(folder).sha256)


def law_compared(folder: Path, label: Label) -> Json | None:
    """Return the law of an answer beside the true one; None: no law was answered.

    Raises
    ------
    AnalysisInputError
        The answer is damaged.
    """
    given = _read(folder / ANSWER, Answer).law
    if given is None:
        return None
    true = next((list(e.law) for e in label.effects if e.law), None)
    right = [true is not None and a == b for a, b in zip(given, true or given, strict=True)]
    return {
        "answer": given,
        "truth": true,
        "right": dict(zip(OF_A_LAW, right, strict=True)),
    }


def judge(label: Label, answer: Sequence[str]) -> Outcome:
    """Return the outcome of an answer against the truth.

    Only what was hidden counts: what the world has whatever is hidden may be answered or not.
    right: the names of the truth; what the truth contains may stand beside. alias: as many names,
    each of the truth or an alias of it. partly: some of them. wrong: none.
    """
    truth = set(label.answer)
    given = set(answer) - (set(label.world) - truth) or {"none"}
    if truth in (given, given - set(label.beside)):
        return "right"
    near = [{name, *label.like.get(name, ())} for name in label.answer]
    if len(given) == len(truth) and all(given & names for names in near):
        return "alias"
    return "partly" if given & set().union(*near) else "wrong"


def _challenge(folder: Path) -> Challenge:
    if not (folder / PUBLIC).exists():
        raise NotFoundError(
            f"no challenge is there, as it has no {PUBLIC}",
            part=str(folder),
            todo=f"make one: rigctl challenge new {folder}",
        )
    return _read(folder / PUBLIC, Challenge)


def _names(answer: str, known: set[str]) -> list[str]:
    names = [name.strip() for name in answer.split(",")]
    for name in names:
        if name not in known:
            raise NotFoundError(
                "nothing that could be hidden has this name",
                part="--answer",
                value=repr(name),
                todo=f"choose of {', '.join(sorted(known))}",
            )
    alone = [name for name in names if name in ALONE]
    if len(set(names)) < len(names) or (alone and len(names) > 1):
        raise SettingsError(
            f"a name stands twice, or beside {' or '.join(ALONE)}",
            part="--answer",
            value=repr(answer),
            todo="give each effect once, or one of these words alone",
        )
    return names


def _opened(path: Path, sha256: str) -> Label:
    try:
        content = base64.b64decode(path.read_bytes().replace(b"\n", b""), validate=True)
    except (OSError, binascii.Error) as error:
        raise AnalysisInputError(f"cannot be read: {error}", part=str(path)) from error
    found = hashlib.sha256(content).hexdigest()
    if found != sha256:
        raise RefusedError(
            "the label is not the one that was sealed",
            part=str(path),
            value=f"SHA-256 {found}",
            limit=sha256,
            todo="restore both files of the seal as they were made, or take another challenge",
        )
    return _parsed(path, content[SALT_BYTES:], Label)


def _read(path: Path, model: type[Model]) -> Model:
    try:
        return _parsed(path, path.read_bytes(), model)
    except OSError as error:
        raise AnalysisInputError(f"cannot be read: {error}", part=str(path)) from error


def _parsed(path: Path, content: bytes, model: type[Model]) -> Model:
    try:
        return model.model_validate_json(content)
    except ValidationError as error:
        fault = error.errors()[0]
        place = ".".join(str(part) for part in fault["loc"])
        raise AnalysisInputError(f"{place}: {fault['msg']}", part=str(path)) from error


def _unwritable(folder: Path, error: OSError) -> StoreError:
    return StoreError(f"cannot be written: {error}", part=str(folder))


def summary(
    label: Label,
    answer: Sequence[str],
    outcome: Outcome,
    *,
    as_json: bool,
    law: Json | None = None,
) -> str:
    """Return what a reveal prints: a few lines, or one JSON document.

    Parameters
    ----------
    law
        The law that was answered beside the true one.
    """
    if as_json:
        document: Mapping[str, object] = {
            "outcome": outcome,
            "answer": list(answer),
            "truth": label.answer,
            "effects": [effect.model_dump(exclude_none=True) for effect in label.effects],
            "world": label.world,
            "law": law,
        }
        return json.dumps(document, allow_nan=False)
    always = f", on top of {', '.join(label.world)}, which this world always has"
    lines = [
        f"{outcome}: answered {', '.join(answer)}; the truth is {', '.join(label.answer)}"
        f"{always if label.world else ''}"
    ]
    lines += [
        f"hidden: {hidden.effect}, {hidden.amplitude:g}"
        f"{'' if hidden.unit == '1' else ' ' + hidden.unit} ({hidden.meaning})"
        for hidden in label.effects
    ]
    lines += [
        f"its law: {hidden.law[0]} against {hidden.law[1]}, {hidden.law[2]}"
        for hidden in label.effects
        if hidden.law
    ]
    if law is not None:
        right = [name for name in OF_A_LAW if law["right"][name]]
        stated = f"{law['answer'][0]} against {law['answer'][1]}, {law['answer'][2]}"
        lines.append(f"answered law: {stated}; right: {', '.join(right) or 'nothing of it'}")
    return "\n".join([*lines, "the label is the one sealed when the campaign was made"])
