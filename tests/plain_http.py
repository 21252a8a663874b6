"""Requests to a daemon on this host by one client without certificates.

A client made for each request reads all certificates first: 20 ms of the processor, a hundred times
in a wait for a daemon. No connection is kept: the daemon may be ended while a test goes on.
"""

from __future__ import annotations

import httpx

REQUESTS = httpx.Client(
    trust_env=False, verify=False, limits=httpx.Limits(max_keepalive_connections=0)
)


def lives(url: str) -> bool:
    """Return whether a daemon answers at an address without encryption."""
    try:
        return REQUESTS.get(f"{url}/health/live").is_success
    except httpx.TransportError:
        return False
