"""The reason in the body of a stop: taken where it can be read at once, never waited for."""

from __future__ import annotations

from rigctl.service.guards.bodies import loads
from rigctl.service.models import ReleaseOrder

REASON_WAIT_S = 0.02
"""A stop waits this long for the reason in its body, and no longer, s."""

LONGEST_REASON = 16_384
"""Bytes of a body that are read for a reason."""

NO_REASON = "emergency stop by REST"


def reason_of(body: bytes) -> str:
    """Return the reason that a body states, or `NO_REASON` where it states none."""
    try:
        return ReleaseOrder.model_validate(loads(body)).reason
    except (ValueError, RecursionError):
        return NO_REASON
