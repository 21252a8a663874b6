"""Compile functions to machine code and cache them on disk.

Numba reuses a cached function while the file that defines it is unchanged. A compiled function has
the functions it calls and constants of other files built in; here it is reused while that file and
all that it imports of this package, directly or by way of others, are unchanged.

One process compiles a function while others wait. If two compiled it, one with freshly compiled and
one with cached callees, their results might round differently.
"""

from __future__ import annotations

import os
import re
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba import types
from numba.core import caching

try:
    import fcntl
except ImportError:

    def try_lock(file: int) -> bool:
        """Take the lock; False where another process has it. `file` is open for writing."""
        # The library's type hints have it on Windows alone.
        windows = import_module("msvcrt")
        try:
            windows.locking(file, windows.LK_NBLCK, 1)
        except OSError:
            return False
        return True

else:

    def try_lock(file: int) -> bool:
        """Take the lock; False where another process has it. `file` is open for writing."""
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True


USES = b"from analysis.compiled import"
LONGEST_S, AGAIN_S = 600.0, 0.05
"""Wait for another process, after which it is compiled here too, and time between two looks."""


@cache
def sources() -> str:
    """Return a digest of all files in the folders of this package that hold compiled functions."""
    package = Path(__file__).parent
    folders = {file.parent for file in package.rglob("*.py") if USES in file.read_bytes()}
    digest = sha256()
    for file in sorted(file for folder in folders for file in folder.glob("*.py")):
        digest.update(file.relative_to(package).as_posix().encode() + file.read_bytes())
    return digest.hexdigest()


IMPORT = re.compile(
    rb"^[ \t]*(?:from (analysis[\w.]*) import (\([^)]*\)|.*)|import (analysis[\w.]*))", re.MULTILINE
)


@cache
def _read(file: Path) -> tuple[bytes, frozenset[Path]]:
    """Return a digest of a file, and the files of this package that it imports."""
    content, package = file.read_bytes(), Path(__file__).parent
    found: set[Path] = set()
    for module, names, whole in IMPORT.findall(content):
        base = package.joinpath(*(module or whole).decode().split(".")[1:])
        # What is imported from a folder may be a file of it.
        each = [base, *(base / word for word in re.findall(r"\w+", names.decode()))]
        for path in each:
            found |= {path.with_suffix(".py"), path / "__init__.py"}
    return sha256(content).digest(), frozenset(path for path in found if path.is_file())


@cache
def built_in(file: Path) -> str:
    """Return a digest of a file and of all files of this package that it imports in the end."""
    files, new = set[Path](), {file}
    while new:
        files |= new
        new = {path for each in new for path in _read(each)[1]} - files
    digest = sha256()
    for each in sorted(files):
        digest.update(each.name.encode() + _read(each)[0])
    return digest.hexdigest()


_here = threading.RLock()
"""Taken before any lock on disk: the compiler's library compiles in one thread at a time."""


@contextmanager
def alone(function: str) -> Iterator[None]:
    """Compile a function while no other process compiles it.

    The functions that it calls are compiled within it, each under a lock of its own. As none calls
    itself by way of others, two processes never wait for each other.
    """
    # Where users have no numbers (Windows), each has a temporary folder of their own.
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
    """Cache in `__pycache__`, valid while what is built in is unchanged."""

    def get_source_stamp(self) -> str:
        """Return the digest for which a cached function is valid."""
        return built_in(Path(self._py_file))


class OfUser(caching.UserWideCacheLocator):
    """In the user's own folder, where the package's cannot be written."""

    def get_source_stamp(self) -> str:
        """Return the digest for which a cached function is valid."""
        return built_in(Path(self._py_file))


LOCATORS = ",".join(f"{__name__}.{kind.__name__}" for kind in (BesideSource, OfUser))


SUMS = {"reassoc", "contract", "arcp", "nsz"}
F = TypeVar("F", bound=Callable[..., object])
CompilationListener = Callable[[int, int], None]

_functions: set[str] = set()
_compiled_here: set[str] = set()
_listeners: list[CompilationListener] = []


def on_compilation(listener: CompilationListener) -> None:
    """Call a listener after each function that this process compiles because no cache has it.

    Its arguments: number of functions compiled by this process, and number of all functions. The
    first shot compiles nearly all of them. Not called where all are cached.
    """
    _listeners.append(listener)


def compiled(function: F) -> F:
    """Compile a numerical function at its first call and keep the result on disk.

    Sums may be reordered, and a function may be built into those that call it: between processors,
    and between processes, results agree to rounding, not to the bit. A division by zero is
    infinite, as in arrays: checks would keep loops from vector instructions. While it runs other
    threads do: its arrays must be the caller's own.

    Raises
    ------
    TypeError
        At a call with an array that is not contiguous in rows or cannot be written. A function
        compiled for such would from then on serve others in this process too, and round otherwise
        than in a process that met them first.
    """
    # Numba's type hints lack these options. Entry from C is off: no address is taken.
    decorate = cast("Any", numba.njit)(
        cache=True, error_model="numpy", fastmath=SUMS, no_cfunc_wrapper=True, nogil=True
    )
    return _kept(decorate, function, plain=True)


def part(function: F) -> F:
    """Compile a function that only compiled ones call; without a Python wrapper it is faster."""
    # Numba's type hints lack these two options.
    decorate = cast("Any", numba.njit)(
        cache=True,
        error_model="numpy",
        fastmath=SUMS,
        no_cpython_wrapper=True,
        no_cfunc_wrapper=True,
    )
    return _kept(decorate, function)


def _kept(decorate: Callable[[F], Any], function: F, *, plain: bool = False) -> F:
    """Decorate with this module's rules of cache validity and of locking."""
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
        # A literal number has a type of its own; without this each value is compiled again.
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
                # A cache of an earlier version names a type that was removed or moved.
                for index in _indices(dispatcher):
                    index.unlink(missing_ok=True)
                code = compile_here(signature)
        if sum(dispatcher.stats.cache_misses.values()) > missed:
            _compiled_here.add(name)
            for listener in _listeners:
                listener(len(_compiled_here), len(_functions))
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
    """Whether the cache on disk holds a compiled function."""
    return any(_indices(function))


def _indices(function: Callable[..., object]) -> Iterator[Path]:
    """Yield the index files of a compiled function in the cache."""
    dispatcher = cast("Any", function)
    name = f"{Path(dispatcher.py_func.__code__.co_filename).stem}.{dispatcher.py_func.__name__}-*"
    return Path(dispatcher.stats.cache_path).glob(f"{name}.nbi")
