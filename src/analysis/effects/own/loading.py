"""Effects read from a folder of the user's: each file gives an effect, or the fault it has."""

from __future__ import annotations

import ast
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from types import CodeType, ModuleType

from analysis.effects.effect import Effect
from analysis.effects.own.checking import checked
from analysis.effects.own.fault import EffectFault, Fault, exception_text, line_in
from analysis.errors import InputError
from analysis.files import read_bytes


@dataclass(frozen=True, slots=True)
class Loaded:
    """What a folder holds: effects ready for use, under watch, and the faults of the others.

    `files` are those of the effects, in their order.
    """

    effects: tuple[Effect, ...]
    faults: tuple[Fault, ...]
    files: tuple[Path, ...]


def load_effects(folder: Path, known: Sequence[Effect]) -> Loaded:
    """Read every `*.py` of a folder, in the order of their names, and try what each defines.

    The files are run: load only what you would run yourself.

    Parameters
    ----------
    folder
        The folder, or one file.
    known
        Effects whose names are taken, the catalogue.

    Raises
    ------
    InputError
        The folder cannot be read, or holds no `*.py`.
    """
    try:
        there = [folder] if folder.is_file() else folder.iterdir()
        paths = sorted(path for path in there if path.suffix == ".py")
    except OSError as error:
        raise InputError(folder, error.strerror or str(error)) from error
    if not paths:
        raise InputError(folder, "no *.py is here; rigctl effect new NAME writes one")
    taken = {effect.name: "the catalogue" for effect in known}
    effects: list[Effect] = []
    files: list[Path] = []
    faults: list[Fault] = []
    for path in paths:
        try:
            effect = _read(path, taken)
        except EffectFault as fault:
            faults.append(fault.fault)
        else:
            taken[effect.name] = path.name
            effects.append(effect)
            files.append(path)
    return Loaded(tuple(effects), tuple(faults), tuple(files))


def _read(path: Path, taken: dict[str, str]) -> Effect:
    effect = getattr(_run(path), "EFFECT", None)
    line = _effect_line(path)
    if not isinstance(effect, Effect):
        raise _fault(path, line, "defines no effect", "define EFFECT, as rigctl effect new does")
    found = checked(effect, path, line)
    if found.name in taken:
        what = f"has the name of an effect of {taken[found.name]}"
        raise EffectFault(Fault(path, line, found.name, what, "give it another name"))
    return found


def _run(path: Path) -> ModuleType:
    """Run a file as a separate module; its output goes to standard error."""
    name = f"own_effect:{path}"
    try:
        content = read_bytes(path, "settings_kb")
    except InputError as error:
        raise _fault(path, 1, error.reason, "shorten it") from error
    spec = spec_from_loader(name, _Fresh(name, str(path), content))
    if spec is None or spec.loader is None:
        raise _fault(path, 1, "cannot be read as Python", "write it as rigctl effect new does")
    module = module_from_spec(spec)
    # Dataclasses of the file look their module up by name.
    sys.modules[name] = module
    try:
        with redirect_stdout(sys.stderr):
            spec.loader.exec_module(module)
    except SyntaxError as error:
        own = error.filename == str(path)
        line = (error.lineno if own else line_in(path, error.__traceback__)) or 1
        raise _fault(path, line, f"is not Python: {error.msg}", "mend the line") from error
    except (Exception, SystemExit) as error:
        line = line_in(path, error.__traceback__) or 1
        raise _fault(
            path, line, f"cannot be run: {exception_text(error)}", "mend the line"
        ) from error
    return module


def _effect_line(path: Path) -> int:
    """Return the line that sets EFFECT; 1 where none does."""
    for node in ast.parse(path.read_bytes()).body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        if any(isinstance(target, ast.Name) and target.id == "EFFECT" for target in targets):
            return node.lineno
    return 1


def _fault(path: Path, line: int, what: str, todo: str) -> EffectFault:
    return EffectFault(Fault(path, line, path.stem, what, todo))


class _Fresh(SourceFileLoader):
    """Takes the source as it was read, and leaves no cache: a file may change within a tick."""

    def __init__(self, fullname: str, path: str, content: bytes) -> None:
        super().__init__(fullname, path)
        self._content = content

    def get_code(self, fullname: str) -> CodeType:
        """Compile the file."""
        code: CodeType = self.source_to_code(self._content, self.path)
        return code
