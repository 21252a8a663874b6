"""How far the requests on one connection are, and which of them must go on within a time."""

from __future__ import annotations

import httptools


class Progress:
    """Follows the bytes of a caller, request after request, as the server's own parser does.

    Attributes
    ----------
    head_bytes
        Bytes of a head that is not whole yet.
    in_body
        A head is whole, and its body is not.
    """

    def __init__(self) -> None:
        # Calls the `on_` methods below.
        self._parser: httptools.HttpRequestParser | None = httptools.HttpRequestParser(self)
        self._begun = self._ended = False
        self.head_bytes = 0
        self.in_body = False

    @property
    def waits_for_head(self) -> bool:
        """Whether something of a request has come, and its head is not whole."""
        return self.head_bytes > 0

    def feed(self, data: bytes) -> None:
        """Take the next bytes.

        Bytes that no parser reads count as a head without end: between requests, behind an error,
        or behind an upgrade without a handler.
        """
        self._ended = False
        try:
            if self._parser is not None:
                self._parser.feed_data(data)
        except httptools.HttpParserUpgrade:
            self._parser, self._ended, self._begun, self.in_body = None, True, False, False
        except httptools.HttpParserError:
            self._parser, self._ended, self.in_body = None, False, False
        if self.in_body or (self._ended and not self._begun):
            self.head_bytes = 0
        else:
            self.head_bytes += len(data)

    def on_message_begin(self) -> None:
        """Note that a request begins."""
        self._begun = True

    def on_headers_complete(self) -> None:
        """Note that its head is whole."""
        self._begun, self._ended, self.in_body = False, True, True

    def on_message_complete(self) -> None:
        """Note that its body is whole too."""
        self._ended, self.in_body = True, False
