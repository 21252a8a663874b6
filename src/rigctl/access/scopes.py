"""Scopes of keys: five words, and the table of the scope that each route needs."""

from __future__ import annotations

import re
from enum import StrEnum
from functools import cache

PREFIX = "/api/v1"
"""Below this path a key is required."""

ESTOP_PATH = f"{PREFIX}/rig/estop"


class Scope(StrEnum):
    """One thing that a key may do; every key may read.

    `read`: look at everything, and have questions about campaigns worked out. `operate`: arm,
    fire, release, commission. `sweep`: start, pause, resume and abort sweeps. `maintain`: exclude,
    include, note, tag, analyse again, save fits, end jobs. `admin`: all of these.
    """

    READ = "read"
    OPERATE = "operate"
    SWEEP = "sweep"
    MAINTAIN = "maintain"
    ADMIN = "admin"


EVERYTHING = frozenset(Scope)
"""What the key may do that the daemon was started with."""

ROUTES: dict[tuple[str, str], Scope] = {
    ("GET", "/rig"): Scope.READ,
    ("POST", "/rig/arm"): Scope.OPERATE,
    ("POST", "/rig/release"): Scope.OPERATE,
    ("GET", "/rig/commissioning"): Scope.READ,
    ("GET", "/rig/commissioning/record"): Scope.READ,
    ("POST", "/rig/commissioning/rewired"): Scope.OPERATE,
    ("POST", "/rig/commissioning/{step}/act"): Scope.OPERATE,
    ("POST", "/rig/commissioning/{step}/answer"): Scope.OPERATE,
    ("GET", "/rig/recorder"): Scope.READ,
    ("GET", "/rig/recorder/picture.png"): Scope.READ,
    ("POST", "/rig/recorder"): Scope.OPERATE,
    ("GET", "/rig/film"): Scope.READ,
    ("POST", "/rig/film"): Scope.OPERATE,
    ("PUT", "/rig/film/{name}"): Scope.OPERATE,
    ("POST", "/shots"): Scope.OPERATE,
    ("GET", "/shots"): Scope.READ,
    ("GET", "/shots/{shot}"): Scope.READ,
    ("GET", "/shots/{shot}/frames/{number}.png"): Scope.READ,
    ("GET", "/shots/{shot}/result"): Scope.READ,
    ("POST", "/shots/{shot}/exclude"): Scope.MAINTAIN,
    ("POST", "/shots/{shot}/include"): Scope.MAINTAIN,
    ("PUT", "/shots/{shot}/note"): Scope.MAINTAIN,
    ("PUT", "/shots/{shot}/tags"): Scope.MAINTAIN,
    ("POST", "/sweeps"): Scope.SWEEP,
    ("GET", "/sweeps"): Scope.READ,
    ("GET", "/sweeps/{sweep}"): Scope.READ,
    ("GET", "/sweeps/{sweep}/steps"): Scope.READ,
    ("POST", "/sweeps/{sweep}/pause"): Scope.SWEEP,
    ("POST", "/sweeps/{sweep}/resume"): Scope.SWEEP,
    ("POST", "/sweeps/{sweep}/abort"): Scope.SWEEP,
    ("GET", "/campaigns"): Scope.READ,
    ("GET", "/campaigns/{campaign}"): Scope.READ,
    ("PUT", "/campaigns/{campaign}/note"): Scope.MAINTAIN,
    ("PUT", "/campaigns/{campaign}/tags"): Scope.MAINTAIN,
    ("POST", "/campaigns/{campaign}/reanalyse"): Scope.MAINTAIN,
    ("GET", "/campaigns/{campaign}/report"): Scope.READ,
    ("GET", "/campaigns/{campaign}/agreement"): Scope.READ,
    ("GET", "/campaigns/{campaign}/structure"): Scope.READ,
    ("GET", "/campaigns/{campaign}/ranking"): Scope.READ,
    ("POST", "/campaigns/{campaign}/explain"): Scope.READ,
    ("POST", "/campaigns/{campaign}/propose"): Scope.READ,
    ("POST", "/campaigns/{campaign}/next"): Scope.READ,
    ("POST", "/campaigns/{campaign}/fits"): Scope.MAINTAIN,
    ("GET", "/campaigns/{campaign}/fits"): Scope.READ,
    ("GET", "/campaigns/{campaign}/fits/{fit}"): Scope.READ,
    ("GET", "/effects"): Scope.READ,
    ("GET", "/effects/own"): Scope.READ,
    ("GET", "/effects/{effect}"): Scope.READ,
    ("GET", "/jobs"): Scope.READ,
    ("GET", "/jobs/{job}"): Scope.READ,
    ("DELETE", "/jobs/{job}"): Scope.MAINTAIN,
    ("GET", "/events"): Scope.READ,
}
"""Every route below `PREFIX` but the emergency stop, which needs no key."""


def needed(method: str, path: str) -> Scope:
    """Return the scope that a request needs.

    An unknown path needs `read`, to be answered 404; a method that the path does not have needs
    the highest scope of its others.
    """
    below = path.removeprefix(PREFIX)
    effective = "GET" if method == "HEAD" else method
    found = (s for (m, pattern), s in _patterns() if m == effective and pattern.fullmatch(below))
    return next(found, Scope.READ)


def allows(held: frozenset[Scope], required: Scope) -> bool:
    """Whether a key with these scopes has the required one."""
    return required is Scope.READ or required in held or Scope.ADMIN in held


@cache
def _patterns() -> list[tuple[tuple[str, re.Pattern[str]], Scope]]:
    def pattern(template: str) -> re.Pattern[str]:
        return re.compile("[^/]+".join(map(re.escape, re.split(r"\{[^}]*\}", template))))

    return [((method, pattern(path)), scope) for (method, path), scope in ROUTES.items()]
