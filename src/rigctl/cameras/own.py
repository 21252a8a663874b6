"""A lab's own camera, by the function that its configuration names."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import cast

from rigctl.cameras.capture import Capture
from rigctl.cameras.live import LiveCapture
from rigctl.cameras.memory import MemoryCamera, MemoryCapture
from rigctl.cameras.playback import VideoSource
from rigctl.config import OwnCamera
from rigctl.errors import ConfigurationError


def own_capture(section: OwnCamera) -> Capture:
    """Call the factory with its section, and make a capture of the camera that it returns.

    Raises
    ------
    ConfigurationError
        The function cannot be loaded, or returns no camera.
    """
    module, _, name = section.factory.partition(":")
    try:
        factory = cast(
            "Callable[[OwnCamera], object]", getattr(importlib.import_module(module), name)
        )
    except (ImportError, AttributeError) as error:
        raise ConfigurationError(
            f"cannot be loaded: {error}",
            part="camera.factory",
            value=repr(section.factory),
            todo="name an installed module, or one in PYTHONPATH, and a function in it",
        ) from error
    camera = factory(section)
    if isinstance(camera, MemoryCamera):
        return MemoryCapture(section, camera)
    if isinstance(camera, VideoSource):
        return LiveCapture(section, camera)
    raise ConfigurationError(
        "returns neither a VideoSource nor a MemoryCamera: a method is missing",
        part="camera.factory",
        value=type(camera).__name__,
        todo="compare its methods with those of the guide 'add a camera'",
    )
