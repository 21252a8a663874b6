"""Machine code of which a process holds one piece for each function.

The compiler's library copies every function into each that calls it and optimises each copy again:
a third of the time of compiling. It also leaves the copies visible, and the process takes whichever
it has met first: the copy in the caller or the function by itself. The two may round differently,
so that what a process computes would depend on what it has run before, or on whether it has
compiled a function or read it from disk.

Here a function that is too large to be built into its callers is compiled once and called where it
lies; who is kept on disk takes along what it calls. Copies of smaller ones are hidden from all but
the function that holds them.
"""

from __future__ import annotations

import gc
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, cast

import llvmlite.binding as llvm
from numba import extending
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.compiler_lock import global_compiler_lock
from numba.np import arrayobj

SHARED, HIDDEN, VISIBLE = "linkonce_odr", "internal", "external"
OURS, ENVIRONMENT = f"_ZN{len(__name__.split('.')[0])}{__name__.split('.')[0]}", "_ZN08NumbaEnv"
LARGE = 200
"""Lines of intermediate code; the compiler builds in what has about 50, some with up to 100."""
WAYS_IN = "_ZN7cpython", "cfunc."
NAME = re.compile(r'^define [^@]*@"?([^"(]+)"?\(')
LINKAGE = re.compile(rf"^define (?:{SHARED} |{HIDDEN} )?")
SELDOM = 100_000, 50, 1000
"""When garbage is looked for meanwhile: the compiler keeps nearly all that it makes, and a tenth of
its time would go into looking through it again."""


@dataclass(frozen=True)
class Piece:
    """Machine code of a library: its name, the code, the names in it and those that it calls."""

    name: str
    code: bytes
    names: tuple[str, ...]
    calls: tuple[str, ...]


_pieces: dict[str, Piece] = {}
"""What this process holds, by the names in it."""
_read: list[object] = []
"""Libraries read from disk for what others call: the engine knows them only weakly."""


_library = cast("Any", JITCodeLibrary)


class OwnLibrary(_library):  # type: ignore[misc, valid-type]
    """A library of the compiler that calls large functions where they lie."""

    _names: tuple[str, ...] = ()
    _calls: tuple[str, ...] = ()
    _waits = False

    def _finalize_final_module(self) -> None:
        """Write machine code where somebody will call it, after what callers take is put aside."""
        module = self._final_module
        defined = [f for f in module.functions if not f.is_declaration]
        own = [f.name for f in defined if f.linkage.name == VISIBLE]
        taken = [f for f in defined if f.linkage.name == SHARED]
        text = str(module)
        sizes = _sizes(text)
        large = {name for name in own if name.startswith(OURS) and sizes[name] > LARGE}
        self._shared_module = _module(_declared(text, large) if large else _offered(text, own))
        for function in taken:
            function.linkage = HIDDEN
        self._names = tuple(own)
        declared = [f.name for f in module.functions if f.is_declaration]
        self._calls = tuple(name for name in declared if name in _pieces)
        self._waits = True
        self._finalize_dynamic_globals()
        self._finalized = True
        if large:
            self._write()
        else:
            self._place_environments()

    def _write(self) -> None:
        """Have machine code written, and keep it for those that call it."""
        self._waits = False
        super()._finalize_final_module()
        if self._object_caching_enabled and self._compiled_object is not None:
            piece = Piece(self.name, self._compiled_object, self._names, self._calls)
            _pieces.update(dict.fromkeys(self._names, piece))

    def _place_environments(self) -> None:
        """Give the compiler's library the places that it fills, where no code is written yet."""
        places = [
            v.name for v in self._shared_module.global_variables if v.name.startswith(ENVIRONMENT)
        ]
        text = "\n".join(f"@{name} = common global ptr null" for name in places)
        if places:
            self._codegen._add_module(_module(text))
            self._codegen._engine.finalize_object()

    def get_pointer_to_function(self, name: str) -> int:
        """Return where a function lies, 0 where it is none of these."""
        self._ensure_finalized()
        if self._waits:
            if name not in self._names:
                return 0
            self._write()
        return int(super().get_pointer_to_function(name))

    def serialize_using_object_code(self) -> tuple[str, str, object]:
        """Return what is kept on disk, with all that it calls."""
        self._ensure_finalized()
        code = b"" if self._waits else self._get_compiled_object()
        own = Piece(self.name, code, self._names, self._calls)
        return self.name, "own", (own, _called_by(own), self._shared_module.as_bitcode())

    @classmethod
    def _unserialize(cls, codegen: Any, state: Any) -> Any:  # noqa: ANN401
        """Return a library as it was kept."""
        name, kind, data = state
        if kind != "own":
            return super()._unserialize(codegen, state)
        own, pieces, offered = data
        for piece in pieces:
            cls(codegen, piece.name)._hold(piece)
        library = cls(codegen, name)
        library._shared_module = llvm.parse_bitcode(offered)
        library._hold(own)
        return library

    def _hold(self, piece: Piece) -> None:
        """Take a piece of machine code from disk, which the process may hold already."""
        self._names, self._calls, self._finalized = piece.names, piece.calls, True
        self._disable_inspection = True
        if not piece.code:
            self._waits = True
            self._place_environments()
        elif piece.names[0] not in _pieces:
            _read.append(self)
            self.enable_object_caching()
            self._set_compiled_object(piece.code)
            super()._finalize_final_module()
            _pieces.update(dict.fromkeys(piece.names, piece))
            self._codegen._engine._defined_symbols.update(piece.names)


def _called_by(piece: Piece) -> list[Piece]:
    """Return all that a piece needs, each after what it needs itself."""
    found: list[Piece] = []
    for name in piece.calls:
        called = _pieces[name]
        found += [one for one in (*_called_by(called), called) if one not in found]
    return found


def _sizes(text: str) -> dict[str, int]:
    """Return how many lines each function of a module has."""
    sizes, name, first = dict[str, int](), "", 0
    for number, line in enumerate(text.splitlines()):
        if line.startswith("define "):
            name, first = _name(line), number
        elif line == "}":
            sizes[name] = number - first
    return sizes


def _name(line: str) -> str:
    found = NAME.match(line)
    if found is None:
        raise ValueError(f"a function of unknown form in what the compiler has made: {line}")
    return found[1]


def _declared(text: str, large: set[str]) -> str:
    """Return a module that only says how large functions are called."""
    lines = []
    for line in text.splitlines():
        if line.startswith("define ") and _name(line) in large:
            lines.append(LINKAGE.sub("declare ", line).removesuffix(" {"))
        elif line.startswith(("target ", "attributes ", "%")) or line.startswith(f"@{ENVIRONMENT}"):
            lines.append(line)
    return "\n".join(lines)


def _offered(text: str, own: list[str]) -> str:
    """Return a module of functions to be built into others, without the ways in from Python."""
    lines, within = [], True
    for line in text.splitlines():
        if line.startswith("define "):
            name = _name(line)
            within = not name.startswith(WAYS_IN)
            if within and name in own:
                lines.append(LINKAGE.sub(f"define {SHARED} ", line))
                continue
        if within:
            lines.append(line)
        within = within or line == "}"
    return "\n".join(lines)


def _module(text: str) -> Any:  # noqa: ANN401
    module = llvm.parse_assembly(text)
    module.verify()
    return module


def refuse_shapes(given: object, taken: object) -> None:
    """Refuse to assign an array to a slice of another shape."""


@extending.overload(refuse_shapes)
def _refuse_shapes(given: object, taken: object) -> Any:  # noqa: ANN401
    def refuse(given: object, taken: object) -> None:
        raise ValueError("cannot assign an array to a slice of another shape")

    return refuse


@contextmanager
def complete() -> Iterator[None]:
    """Have what is compiled meanwhile call large functions where they lie; one thread compiles."""
    codegen = cast("Any", JITCPUCodegen)
    with global_compiler_lock:
        before = codegen._library_class, arrayobj.raise_with_shape_context
        often = gc.get_threshold()
        gc.set_threshold(*SELDOM)
        codegen._library_class, arrayobj.raise_with_shape_context = OwnLibrary, refuse_shapes
        try:
            yield
        finally:
            codegen._library_class, arrayobj.raise_with_shape_context = before
            gc.set_threshold(*often)
