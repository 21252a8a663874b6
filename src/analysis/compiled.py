"""Functions compiled to machine code, typed for the rest of the program, and where they are kept.

The compiler's library takes a kept function for fresh while the file that defines it is unchanged.
Compiled functions have those they call, and constants of other files, built in: a fresh one here is
one whose whole room is unchanged.

Each is compiled by one process, however many wait for it. Two that compile the same function, one
with the functions it calls just compiled and one with them as kept, may round differently.
"""

from __future__ import annotations

import os
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba import types
from numba.core import caching

from analysis.file_lock import try_lock

USES = b"from analysis.compiled import"
LONGEST_S, AGAIN_S = 600.0, 0.05
"""Wait for another process, after which it is compiled here too, and time between two looks."""


@cache
def sources() -> str:
    """Return a digest of every file in a folder of this package where functions are compiled."""
    package = Path(__file__).parent
    folders = {file.parent for file in package.rglob("*.py") if USES in file.read_bytes()}
    digest = sha256()
    for file in sorted(file for folder in folders for file in folder.glob("*.py")):
        digest.update(file.relative_to(package).as_posix().encode() + file.read_bytes())
    return digest.hexdigest()


_here = threading.RLock()
"""Taken before any lock on disk: the compiler's library compiles in one thread at a time."""


@contextmanager
def alone(function: str) -> Iterator[None]:
    """Compile a function while no other process compiles it.

    The functions that it calls are compiled within it, each under a lock of its own. As none calls
    itself by way of others, two processes never wait for each other.
    """
    # Where users have no numbers, each has a folder for temporary files of his own.
    user = os.getuid() if hasattr(os, "getuid") else "user"
    folder = Path(tempfile.gettempdir()) / f"rigctl-{user}-{sources()[:16]}"
    folder.mkdir(mode=0o700, exist_ok=True)
    with _here, (folder / function).open("a", encoding="utf-8") as file:
        _wait_for(file.fileno())
        yield


def _wait_for(file: int) -> None:
    """Take the lock, or go on without it after LONGEST_S; closing the file gives it back."""
    until = time.monotonic() + LONGEST_S
    while time.monotonic() < until and not try_lock(file):
        time.sleep(AGAIN_S)


class BesideSource(caching.InTreeCacheLocator):
    """In `__pycache__`, as long as the sources are what they were."""

    def get_source_stamp(self) -> str:
        """Return what a kept function is fresh by."""
        return sources()


class OfUser(caching.UserWideCacheLocator):
    """In the user's own folder, where the package's cannot be written."""

    def get_source_stamp(self) -> str:
        """Return what a kept function is fresh by."""
        return sources()


LOCATORS = ",".join(f"{__name__}.{kind.__name__}" for kind in (BesideSource, OfUser))


SUMS = {"reassoc", "contract", "arcp", "nsz"}
F = TypeVar("F", bound=Callable[..., object])
Told = Callable[[int, int], None]

_functions: set[str] = set()
_compiled_here: set[str] = set()
_told: list[Told] = []


def tell_of_compiling(told: Told) -> None:
    """Have a callback told of each function that is compiled here and was not kept on disk.

    It is told how many this process has compiled, and how many it knows: nearly all of them are
    compiled by the first shot, in some order. Where all were kept it is told of none.
    """
    _told.append(told)


def compiled(function: F) -> F:
    """Compile a numerical function at its first call and keep the result on disk.

    Sums may be reordered, and a function may be built into those that call it: between processors,
    and between processes, results agree to rounding, not to the bit. A division by zero is
    infinite, as in arrays: checks would keep loops from vector instructions.

    Raises
    ------
    TypeError
        At a call with an array that is not contiguous in rows or cannot be written. A function
        compiled for such would from then on serve others in this process too, and round otherwise
        than in a process that met them first.
    """
    # These options are missing from the library's type hints; nobody takes an address from outside.
    decorate = cast("Any", numba.njit)(
        cache=True, error_model="numpy", fastmath=SUMS, no_cfunc_wrapper=True
    )
    return _kept(decorate, function, plain=True)


def part(function: F) -> F:
    """Compile a function that only compiled ones call: it compiles faster without a way in."""
    # These two options are missing from the library's type hints.
    decorate = cast("Any", numba.njit)(
        cache=True,
        error_model="numpy",
        fastmath=SUMS,
        no_cpython_wrapper=True,
        no_cfunc_wrapper=True,
    )
    return _kept(decorate, function)


def _kept(decorate: Callable[[F], Any], function: F, *, plain: bool = False) -> F:
    """Decorate with our own rules of how long a function is kept and who compiles it."""
    config = cast("Any", numba.config)
    before, config.CACHE_LOCATOR_CLASSES = config.CACHE_LOCATOR_CLASSES, LOCATORS
    try:
        dispatcher = decorate(function)
    finally:
        config.CACHE_LOCATOR_CLASSES = before
    compile_here = dispatcher.compile
    name = f"{function.__module__}.{function.__name__}"
    _functions.add(name)

    def compile_alone(signature: tuple[Any, ...]) -> object:
        # A number that is written at a call would be a kind of its own: each, compiled once more.
        signature = tuple(cast("Any", types).unliteral(kind) for kind in signature)
        strange = [kind for kind in arrays_of(signature) if kind.layout != "C" or not kind.mutable]
        if plain and strange:
            message = f"{name} takes arrays that are contiguous in rows and can be written"
            raise TypeError(f"{message}, not {strange[0]}; pass numpy.ascontiguousarray of it")
        with alone(name):
            missed = sum(dispatcher.stats.cache_misses.values())
            try:
                code = compile_here(signature)
            except (ImportError, AttributeError):
                # What an earlier version kept names a type that is no more, or lies elsewhere.
                for index in _indices(dispatcher):
                    index.unlink(missing_ok=True)
                code = compile_here(signature)
        if sum(dispatcher.stats.cache_misses.values()) > missed:
            _compiled_here.add(name)
            for told in _told:
                told(len(_compiled_here), len(_functions))
        return code

    dispatcher.compile = compile_alone
    return cast("F", dispatcher)


def arrays_of(kinds: Iterable[object]) -> Iterator[Any]:
    """Yield the types of all arrays among arguments, those in tuples too."""
    for kind in kinds:
        if isinstance(kind, types.Array):
            yield kind
        elif isinstance(kind, types.BaseTuple):
            yield from arrays_of(cast("Any", kind).types)


def kept_on_disk(function: Callable[..., object]) -> bool:
    """Tell whether a compiled function has been compiled here before."""
    return any(_indices(function))


def _indices(function: Callable[..., object]) -> Iterator[Path]:
    """Yield the lists of what is kept of a compiled function."""
    dispatcher = cast("Any", function)
    name = f"{Path(dispatcher.py_func.__code__.co_filename).stem}.{dispatcher.py_func.__name__}-*"
    return Path(dispatcher.stats.cache_path).glob(f"{name}.nbi")
