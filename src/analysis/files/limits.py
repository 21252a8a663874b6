"""Limits of the files that are read: pixels, frames, bytes, depth and time."""

from __future__ import annotations

import os
from functools import lru_cache

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from analysis.errors import InputError

VARIABLE = "RIGCTL_FILES"
"""Environment variable that holds the limits as JSON: processes started later have the same."""


class FileLimits(BaseModel):
    """Limits of files that are read; with the defaults, a refusal takes at most 5 s and 1 GB."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)

    frame_pixels: int = Field(default=16_777_216, ge=1, description="pixels of one frame")
    frames: int = Field(default=10_000, ge=1, description="frames of one shot")
    frames_mb: float = Field(
        default=400.0, gt=0, description="unpacked frames of one shot, 10^6 bytes"
    )
    decode_s: float = Field(
        default=5.0, gt=0, description="processor time to unpack the frames of one shot, s"
    )
    document_mb: float = Field(default=16.0, gt=0, description="a JSON file, 10^6 bytes")
    settings_kb: float = Field(
        default=256.0, gt=0, description="a TOML file or the file of an effect, 10^3 bytes"
    )
    depth: int = Field(default=64, ge=1, le=200, description="levels within a JSON or TOML file")
    table_mb: float = Field(default=4000.0, gt=0, description="a CSV file, 10^6 bytes")
    table_fields: int = Field(
        default=5_000_000, ge=1, description="fields of a CSV file that is held in memory"
    )
    line_kb: float = Field(
        default=1000.0, gt=0, description="a line of a CSV file, 10^3 characters"
    )


def set_file_limits(limits: FileLimits | None) -> None:
    """Set the limits of this process and of those that it starts; None: no change."""
    if limits is not None:
        os.environ[VARIABLE] = limits.model_dump_json()


def file_limits() -> FileLimits:
    """Return the limits in force: those of the environment, else the defaults.

    Raises
    ------
    InputError
        The environment variable holds no valid limits.
    """
    return _parsed(os.environ.get(VARIABLE, "{}"))


@lru_cache(maxsize=8)
def _parsed(text: str) -> FileLimits:
    try:
        return FileLimits.model_validate_json(text)
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(map(str, first["loc"])) or "the text"
        raise InputError(f"environment variable {VARIABLE}", f"{field}: {first['msg']}") from error
