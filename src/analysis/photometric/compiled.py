"""Functions compiled to machine code, typed for the rest of the program."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., object])


def compiled(function: F) -> F:
    """Compile a numerical function at its first call and keep the result on disk.

    Sums may be reordered, so results repeat to rounding only between processors of one kind.
    """
    decorate = numba.njit(cache=True, fastmath={"reassoc", "contract", "arcp", "nsz"})
    return cast("F", decorate(function))
