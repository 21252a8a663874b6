"""Libraries that come with an extra of this package."""

from __future__ import annotations

from importlib.util import find_spec

from rigctl.errors import ConfigurationError


def require(library: str, extra: str) -> None:
    """Make sure that a library of an extra is there.

    Raises
    ------
    ConfigurationError
        It is not installed.
    """
    if find_spec(library) is None:
        raise ConfigurationError(
            f"the library {library} is not installed",
            part=f"extra {extra}",
            todo=f"install rigctl[{extra}]",
        )
