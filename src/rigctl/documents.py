"""What an object of JSON is in Python; its form is in the page of whoever writes or reads it."""

from __future__ import annotations

from typing import Any

Json = dict[str, Any]
