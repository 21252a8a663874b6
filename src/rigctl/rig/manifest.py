"""What stands beside a shot's frames: all that an analysis needs, years later, without the rig."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.metadata import version
from typing import Any

from analysis.setup import setup_document
from rigctl.cameras.capture import RecordingConfirmation
from rigctl.config import Configuration
from rigctl.devices.roles import FireReceipt
from rigctl.rig.interlocks import Interlock
from rigctl.store.records import ShotRecord

FORMAT = 2
"""2: the set-up is one table; manifests of format 1 are read as before."""


def manifest(
    shot: ShotRecord,
    configuration: Configuration,
    recording: RecordingConfirmation,
    receipt: FireReceipt | None,
    conditions: Iterable[Interlock],
) -> dict[str, Any]:
    """Return the manifest of a fired shot; every quantity has its unit in its name.

    The store adds the entry `frames`: digest, shape, times and lost pictures. Without a receipt
    the trigger confirmed the fire only when asked afterwards.
    """
    return {
        "format": FORMAT,
        "shot": shot.id,
        "number": shot.number,
        "campaign": shot.campaign,
        "note": shot.note,
        "accepted_at": shot.accepted_at.isoformat(),
        "fired_at": None if shot.fired_at is None else shot.fired_at.isoformat(),
        "settings": shot.ordered.model_dump(mode="json"),
        "simulated": shot.simulated,
        "program": {"name": "rigctl", "version": version("rigctl")},
        "configuration": {
            "name": configuration.name,
            "apparatus": configuration.apparatus,
            "sha256": configuration.digest,
        },
        "setup": setup_document(configuration.setup),
        "camera": configuration.camera.model_dump(mode="json"),
        "recording": {"by": recording.by, "evidence": recording.evidence},
        "trigger": None if receipt is None else _receipt(receipt),
        "interlocks": [_condition(condition) for condition in conditions],
    }


def _receipt(receipt: FireReceipt) -> dict[str, Any]:
    return {
        "sequence": receipt.sequence,
        "answer_time_s": receipt.confirmed_at - receipt.sent_at,
        "device_time_us": receipt.device_time_us,
    }


def _condition(condition: Interlock) -> dict[str, Any]:
    return {
        "name": condition.name,
        "value": condition.value,
        "limit": condition.limit,
        "unit": condition.unit,
        "source": condition.source,
    }
