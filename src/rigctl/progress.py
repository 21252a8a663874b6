"""Reports of progress from long work to its caller."""

from collections.abc import Callable

Progress = Callable[[str, float | None], None]
"""Called with the present step in words and the share done, 0 to 1, None where unknown."""
