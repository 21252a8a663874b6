"""The effects there are, by their names: of the catalogue, and of a folder of the user's own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from analysis.effects.catalogue import CATALOGUE, LAUNCH_CATALOGUE
from analysis.effects.effect import Effect
from analysis.effects.own.fault import EffectFault, Fault
from analysis.effects.own.loading import load_effects
from analysis.errors import InputError
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError, NotFoundError

ALL_EFFECTS: tuple[Effect, ...] = (*CATALOGUE, *LAUNCH_CATALOGUE)
"""Those of the catalogue that poses can show, and those of the launch; no name stands twice."""


def effect_named(
    name: str, effects: Sequence[Effect] = CATALOGUE, part: str | None = None
) -> Effect:
    """Return an effect; `NotFoundError`, if there is none of that name, lists those there are."""
    known = {effect.name: effect for effect in effects}
    if name not in known:
        raise NotFoundError(
            "no effect of the catalogue has this name",
            part=part,
            value=repr(name),
            todo=f"choose one of {', '.join(sorted(known))}",
        )
    return known[name]


@dataclass(frozen=True, slots=True)
class Available:
    """The effects of the catalogue and of a folder, and the faults of those that are of no use.

    Attributes
    ----------
    files
        Where each effect of the folder stands, by its name.
    """

    effects: tuple[Effect, ...]
    faults: tuple[Fault, ...]
    files: Mapping[str, Path] = field(default_factory=dict)

    def named(self, name: str, part: str | None = None) -> Effect:
        """Return the effect of a name; `part` is what asks for it.

        Raises
        ------
        AnalysisInputError
            The effect of that name has a fault.
        NotFoundError
            There is none of that name.
        """
        names = {effect.name for effect in self.effects}
        for fault in self.faults:
            if fault.effect == name not in names:
                raise refused(fault)
        return effect_named(name, self.effects, part)

    def own(self) -> list[Json]:
        """Return what each effect of the folder says of itself, with its file."""
        return [
            {**effect_document(effect), "file": str(self.files[effect.name])}
            for effect in self.effects
            if effect.name in self.files
        ]


def available(folder: Path | None, part: str = "--effects") -> Available:
    """Return the effects that poses can show: of the catalogue, and of a folder of the user's.

    The files of the folder are run. `part` is what named the folder.

    Raises
    ------
    AnalysisInputError
        The folder cannot be read, or holds no effect.
    """
    if folder is None:
        return Available(CATALOGUE, ())
    try:
        loaded = load_effects(folder, ALL_EFFECTS)
    except InputError as error:
        raise AnalysisInputError(error.reason, part=f"{part} {error.path}") from error
    names = (effect.name for effect in loaded.effects)
    files = dict(zip(names, loaded.files, strict=True))
    return Available((*CATALOGUE, *loaded.effects), loaded.faults, files)


def refused(fault: Fault) -> AnalysisInputError:
    """Return the error of whatever needs the effect that has a fault."""
    return AnalysisInputError(
        f"{fault.effect}: {fault.what}", part=f"{fault.path}, line {fault.line}", todo=fault.todo
    )


@contextmanager
def faults_refused() -> Iterator[None]:
    """Turn the fault of an effect that is needed into `AnalysisInputError`."""
    try:
        yield
    except EffectFault as error:
        raise refused(error.fault) from error


def effect_document(effect: Effect) -> Json:
    """Return all that an effect says of itself, as commands, REST and the page show it."""
    return {
        "effect": effect.name,
        "title": effect.title,
        "stage": effect.stage,
        "parameters": [
            {
                "symbol": p.symbol,
                "unit": p.unit,
                "meaning": p.meaning,
                "off": p.off,
                "plausible": list(p.plausible),
                "one_sided": p.one_sided,
            }
            for p in effect.parameters
        ],
        "formula": effect.formula,
        "source": effect.source,
        "gives_away": effect.gives_away,
        "confused_with": list(effect.confused_with),
        "variants": [variant.title for variant in effect.variants],
    }
