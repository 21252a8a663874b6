"""Which shot numbers a table has had, in eight bytes each."""

from __future__ import annotations

from array import array

import numpy as np


class NumbersSeen:
    """The numbers of the shots of a table that is read a row at a time.

    Rows are usually in the order of their shots; only a number that is out of order is looked up.
    """

    def __init__(self) -> None:
        self._numbers = array("q")
        self._largest = -1

    def add(self, number: int) -> bool:
        """Add a number; return whether it is there for the first time."""
        if number > self._largest:
            self._largest = number
        elif bool((np.asarray(self._numbers) == number).any()):
            return False
        self._numbers.append(number)
        return True
