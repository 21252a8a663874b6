"""What an object of JSON is in Python; its form is defined where it is written or read."""

from __future__ import annotations

from typing import Any

Json = dict[str, Any]
