"""Files from outside: read within limits, or refused in one sentence."""

from analysis.files.frame_budget import FrameBudget
from analysis.files.limits import FileLimits, file_limits, set_file_limits
from analysis.files.texts import parse_json, parse_toml, read_bytes, read_json, read_toml, toml_text

__all__ = [
    "FileLimits",
    "FrameBudget",
    "file_limits",
    "parse_json",
    "parse_toml",
    "read_bytes",
    "read_json",
    "read_toml",
    "set_file_limits",
    "toml_text",
]
