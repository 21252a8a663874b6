"""The seal: a label set down in a form that no one reads by accident, and its fingerprint.

The label is not secret: whoever decodes the file reads it. What the seal gives is proof that the
label revealed is the label of the day the campaign was made. The salt keeps the fingerprints of
equal labels apart, so that they cannot be looked up.
"""

from __future__ import annotations

import base64
import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np

from simulators.challenge.effects import HIDDEN

SALT_BYTES = 16


def write_seal(folder: Path, label: dict[str, Any], rng: np.random.Generator) -> None:
    """Write `sealed.txt`, Base64 of salt and label, and `challenge.json`, which everyone may read.

    Raises
    ------
    OSError
        The folder cannot be written.
    """
    content = rng.bytes(SALT_BYTES) + json.dumps(label).encode()
    challenge = {
        "format": 1,
        "sha256": hashlib.sha256(content).hexdigest(),
        "names": sorted(effect.name for effect in HIDDEN.values() if effect.known),
    }
    (folder / "sealed.txt").write_bytes(base64.encodebytes(content))
    text = json.dumps(challenge, indent=1) + "\n"
    (folder / "challenge.json").write_text(text, encoding="utf-8")
