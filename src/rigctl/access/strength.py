"""What a key has to be: long, visible, not one character over and over."""

from __future__ import annotations

import os
import secrets
import stat
from dataclasses import dataclass
from pathlib import Path

from rigctl.errors import ConfigurationError

SHORTEST = 16
VARIABLE = "RIGCTL_KEY"
WARNING = f"--key is visible in the list of processes; use --key-file, or {VARIABLE}"


@dataclass(frozen=True, slots=True)
class Chosen:
    """A key chosen by the user, and a warning about the way it was given."""

    key: str
    warning: str | None = None


def new_key() -> str:
    """Return a fresh key of 192 random bits, safe in a URL."""
    return secrets.token_urlsafe(24)


def chosen_key(option: str | None, file: Path | None) -> Chosen | None:
    """Return the key of the option, of the file or of the environment; None without any.

    Raises
    ------
    ConfigurationError
        The file cannot be read.
    """
    if option is not None:
        return Chosen(option, WARNING)
    if file is not None:
        return _read(file)
    known = os.environ.get(VARIABLE)
    return Chosen(known) if known else None


def require_strong(key: str) -> None:
    """Refuse a key that is soon guessed, or that no request can carry.

    Raises
    ------
    ConfigurationError
        It is too short, the same character throughout, or holds other than visible ASCII; the
        error does not repeat it.
    """
    fault = _fault(key)
    if fault is not None:
        raise ConfigurationError(
            fault,
            part="key",
            limit=f"at least {SHORTEST} visible ASCII characters, not all the same",
            todo="choose another, or leave it out and take the one that the daemon makes",
        )


def _fault(key: str) -> str | None:
    if not all("!" <= character <= "~" for character in key):
        return "holds a character that no request can carry"
    if len(key) < SHORTEST:
        return f"is too short with {len(key)} characters"
    return "is one character over and over" if len(set(key)) == 1 else None


def _read(file: Path) -> Chosen:
    try:
        key = file.read_text(encoding="utf-8").strip()
        others = stat.S_IMODE(file.stat().st_mode) & 0o077
    except (OSError, ValueError) as error:
        raise ConfigurationError(
            f"the file of the key cannot be read: {error}",
            part="--key-file",
            value=str(file),
            todo="name a file whose one line is the key",
        ) from error
    warning = f"{file} can be read by others; chmod 600 {file}" if others else None
    return Chosen(key, warning)
