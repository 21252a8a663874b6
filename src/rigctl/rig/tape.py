"""A tape that somebody has erased, and the audit's entry of it."""

from __future__ import annotations

from rigctl.cameras.keypad import Keypad
from rigctl.store.store import Store


def erase_tape(keypad: Keypad, store: Store, actor: str) -> None:
    """Erase the whole tape for somebody; the audit names the sessions that were lost.

    Raises
    ------
    RefusedError, DeviceError
        As the keys of `Keypad`.
    StoreError
        The tape is erased, and that is not on disk.
    """
    lost = keypad.erase()
    if lost:
        store.edits.tape_erased(actor, keypad.name, f"sessions {', '.join(map(str, lost))}")
