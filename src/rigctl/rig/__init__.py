"""The one state machine that may fire, and the interlocks that refuse."""
