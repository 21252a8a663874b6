"""Faults of campaign.toml in words: which key, what is wrong, what was found and is allowed."""

from __future__ import annotations

from pydantic_core import ErrorDetails

_CLAUSES = {
    "missing": "is missing",
    "extra_forbidden": "is not a key of this table",
    "unexpected_keyword_argument": "is not a key of this table",
    "finite_number": "is not finite",
    "float_type": "is not a number",
    "int_type": "is not a whole number",
    "bool_type": "is neither true nor false",
    "string_type": "is not a text",
    "list_type": "is not a list",
    "model_type": "is not a table",
    "dataclass_type": "is not a table",
    "tuple_type": "is not a list",
    "string_too_short": "is empty",
    "too_short": "is of the wrong length",
    "too_long": "is of the wrong length",
}
_LIMITS = {
    "gt": "more than {:g}",
    "ge": "at least {:g}",
    "le": "at most {:g}",
    "expected": "{}",
}


def fault(error: ErrorDetails) -> str:
    """Return one fault as a clause that begins with the key."""
    if error["type"] == "missing" and isinstance(error["input"], list):
        # An entry of a list is not missing by its number: the list is too short.
        error = {**error, "type": "too_short", "loc": error["loc"][:-1]}
    key = ".".join(str(part) for part in error["loc"])
    context = error.get("ctx", {})
    if error["type"] == "value_error":
        return f"{key}: {context['error']}"
    clause = _CLAUSES.get(error["type"], "is out of range")
    if error["type"] == "missing":
        return f"{key}: {clause}"
    limits = [text.format(context[name]) for name, text in _LIMITS.items() if name in context]
    if error["type"] in {"too_short", "too_long"}:
        limits = ["2 entries"]
    # A whole table is no value: each wrong field in it has a fault of its own.
    shown = [] if isinstance(error["input"], dict) else [f"found {error['input']!r}"]
    shown += [f"allowed {limit}" for limit in limits]
    text = f"{key}: {clause} ({', '.join(shown)})" if shown else f"{key}: {clause}"
    if error["type"] == "less_than_equal" and key.endswith("_m"):
        found = error["input"]
        return f"{text}; the unit is the metre, {found:g} mm are {found / 1000:g}"
    return text
