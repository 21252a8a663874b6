"""What a job's process is kept from: the network, and files with secrets.

Jobs run the files of own effects, which are programs. The kernel gives a process a user, network
and mount namespace of its own (user_namespaces(7)): it then has no network but its own loopback,
cannot look into processes of others, and finds nothing in a file on which nothing is mounted. What
it may write, and whom it may signal, stays as it is for the user who runs the daemon.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Sequence
from pathlib import Path

_NEWNS, _NEWUSER, _NEWNET = 0x00020000, 0x10000000, 0x40000000
_BIND, _RECURSIVE, _PRIVATE = 0x1000, 0x4000, 0x40000
_CAPBSET_DROP, _NO_NEW_PRIVS = 24, 38
_LAST_CAPABILITY = 63
_CAPABILITY_VERSION = 0x20080522

ENCLOSED = "no network, no key, no look into other processes"
ON_NETWORK = "no key, no look into other processes; the network is open for the catalogue's server"
NETWORK_ALONE = "no network; {path} could not be hidden ({why})"
OPEN = "network and key file are open to it: the kernel gives no namespaces ({why})"


def enclose(hidden: Sequence[Path], *, network: bool) -> str:
    """Keep this process, and all that it starts, from these files and perhaps the network.

    It must have one thread still.

    Returns
    -------
    What it is kept from, in words for the job's record; also where the kernel refuses.
    """
    user, group = os.getuid(), os.getgid()
    try:
        _call("unshare", _NEWUSER | _NEWNS | (0 if network else _NEWNET))
    except OSError as error:
        return OPEN.format(why=error.strerror)
    try:
        _map("setgroups", "deny")
        _map("uid_map", f"{user} {user} 1")
        _map("gid_map", f"{group} {group} 1")
        _call("mount", None, b"/", None, _RECURSIVE | _PRIVATE, None)
        for path in hidden:
            if path.exists():
                _call("mount", b"/dev/null", os.fsencode(path), None, _BIND, None)
    except OSError as error:
        return NETWORK_ALONE.format(path=", ".join(map(str, hidden)), why=error.strerror)
    finally:
        _give_up_capabilities()
    return ON_NETWORK if network else ENCLOSED


def _map(name: str, text: str) -> None:
    Path("/proc/self", name).write_text(text, encoding="ascii")


def _give_up_capabilities() -> None:
    """Give up what a new user namespace gives; what is mounted stays."""
    for capability in range(_LAST_CAPABILITY + 1):
        try:
            _call("prctl", _CAPBSET_DROP, capability, 0, 0, 0)
        except OSError:
            break
    _call("prctl", _NO_NEW_PRIVS, 1, 0, 0, 0)
    header = (ctypes.c_uint32 * 2)(_CAPABILITY_VERSION, 0)
    _call("capset", header, (ctypes.c_uint32 * 6)())


def _call(name: str, *arguments: object) -> None:
    library = ctypes.CDLL(None, use_errno=True)
    if getattr(library, name)(*arguments) != 0:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
