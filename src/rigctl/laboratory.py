"""The simulated laboratory that a configuration names, loaded by its factory."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from pathlib import Path
from typing import Protocol, cast

from rigctl.config import Simulation
from rigctl.devices import build
from rigctl.errors import ConfigurationError


class Laboratory(build.Laboratory, Protocol):
    """A simulated laboratory as its factory returns it."""

    def close(self) -> None:
        """Unplug everything and stop every thread."""


def open_laboratory(
    simulation: Simulation | None, scene: Mapping[str, object], folder: Path
) -> Laboratory | None:
    """Open the laboratory in a folder, with what the configuration says of its world.

    Returns
    -------
    None on a real rig.

    Raises
    ------
    ConfigurationError
        The factory is not there, or refuses its options.
    """
    if simulation is None:
        return None
    module, _, name = simulation.factory.partition(":")
    try:
        factory = getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError) as error:
        raise ConfigurationError(
            f"cannot be loaded: {error}",
            part="simulation.factory",
            value=repr(simulation.factory),
            todo="name an installed module and a function in it",
        ) from error
    try:
        # What a configuration names has no type before it runs.
        return cast("Laboratory", factory(folder, simulation.options | {"scene": dict(scene)}))
    except ValueError as error:
        raise ConfigurationError(
            str(error), part="simulation", todo="correct the table [simulation]"
        ) from error
