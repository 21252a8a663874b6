"""Files that come with the program: inside the package when installed, else in the checkout."""

from __future__ import annotations

from pathlib import Path

from rigctl.errors import ConfigurationError

_PACKAGE = Path(__file__).resolve().parent


def shipped(in_package: str, in_checkout: str, *, todo: str) -> Path:
    """Return a file or folder that comes with the program, by its place in either.

    Raises
    ------
    ConfigurationError
        It lies in neither; `todo` has the remedy.
    """
    for path in (_PACKAGE / in_package, _PACKAGE.parents[1] / in_checkout):
        if path.exists():
            return path
    raise ConfigurationError("a file of the program is missing", part=in_package, todo=todo)
