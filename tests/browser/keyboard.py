"""A person without a mouse: goes to what is named by the tabulator, and sees where it stands."""

from __future__ import annotations

import re

from playwright.sync_api import Locator, Page

STOPS = 250
"""After so many a screen has a trap, or what is looked for is not reached by keys."""
AT = """(wanted) => {
  const at = document.activeElement;
  const ring = (part) => part && parseFloat(getComputedStyle(part).outlineWidth) >= 3
    && getComputedStyle(part).outlineStyle === "solid";
  const seen = ring(at) || ring(at.closest(".q-field__control"))
    || ring(at.closest("label")) || ring(at.querySelector(".q-focus-helper"));
  return [at === wanted || wanted.contains(at), Boolean(seen), at.outerHTML.slice(0, 160)];
}"""
"""Whether a part has the focus, whether that is seen, and what has it."""


class Keyboard:
    """Tab, Enter, Space and arrows on one page; the mouse is not touched."""

    def __init__(self, page: Page) -> None:
        self._page = page

    def go_to(self, wanted: Locator) -> None:
        """Press Tab until a part has the focus, which must be seen.

        Raises
        ------
        AssertionError
            No key comes to it, or nothing shows that it has the focus.
        """
        part = wanted.element_handle()
        for _ in range(STOPS):
            self._page.keyboard.press("Tab")
            reached, seen, what = self._page.evaluate(AT, part)
            if reached:
                assert seen, f"focus is not seen: {what}"
                return
        raise AssertionError(f"no key comes to {part}")

    def go_to_named(self, testid: str | re.Pattern[str]) -> None:
        """Press Tab until a part of this name has the focus."""
        part = self._page.get_by_test_id(testid).first
        part.wait_for()
        self.go_to(part)

    def press(self, testid: str | re.Pattern[str], key: str = "Enter") -> None:
        """Go to a part and press a key on it."""
        self.go_to_named(testid)
        self._page.keyboard.press(key)

    def type_into(self, testid: str, text: str) -> None:
        """Go to a field and type over what it holds."""
        self.go_to_named(testid)
        self._page.keyboard.press("Control+a")
        self._page.keyboard.type(text)

    def open_place(self, name: str) -> None:
        """Go to a place of the menu."""
        self.go_to(self._page.get_by_role("link", name=re.compile(f"^{name}$")).first)
        self._page.keyboard.press("Enter")
        self._page.wait_for_function("window.did_handshake")
