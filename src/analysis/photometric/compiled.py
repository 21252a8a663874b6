"""Functions compiled to machine code, typed for the rest of the program."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., object])


def compiled(function: F) -> F:
    """Compile a numerical function at its first call and keep the result on disk.

    Sums may be reordered, so results repeat to rounding only between processors of one kind.
    """
    decorate = numba.njit(cache=True, fastmath={"reassoc", "contract", "arcp", "nsz"})
    return cast("F", decorate(function))


def kept_on_disk(function: Callable[..., object]) -> bool:
    """Tell whether a compiled function has been compiled here before."""
    dispatcher = cast("Any", function)
    name = f"{Path(dispatcher.py_func.__code__.co_filename).stem}.{dispatcher.py_func.__name__}-*"
    return any(Path(dispatcher.stats.cache_path).glob(f"{name}.nbi"))
