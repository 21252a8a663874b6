"""Machine code that holds all that it runs.

The compiler's library leaves the functions that another calls visible in its machine code, and the
process takes whichever it has met first: the copy in the caller or the function by itself. The two
are optimised apart and may round differently, so that what a process computes would depend on what
it has run before, or on whether it has compiled a function or read it from disk.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, cast

from numba.core.codegen import CPUCodeLibrary

SHARED, HIDDEN, VISIBLE = "linkonce_odr", "internal", "external"
_library = cast("Any", CPUCodeLibrary)
_finalize = _library._finalize_final_module


def _finalize_alone(library: Any) -> None:  # noqa: ANN401
    """Hide the functions that a library has taken from others, from all but itself.

    Those who build the library in take it as it was before.
    """
    module = library._final_module
    taken = [f for f in module.functions if not f.is_declaration and f.linkage.name == SHARED]
    if not taken:
        _finalize(library)
        return
    whole = module.clone()
    for function in whole.functions:
        if not function.is_declaration and function.linkage.name == VISIBLE:
            function.linkage = SHARED
    for function in taken:
        function.linkage = HIDDEN
    _finalize(library)
    library._shared_module = whole


@contextmanager
def complete() -> Iterator[None]:
    """Have what is compiled meanwhile complete in itself; one thread at a time compiles."""
    before, _library._finalize_final_module = _library._finalize_final_module, _finalize_alone
    try:
        yield
    finally:
        _library._finalize_final_module = before
