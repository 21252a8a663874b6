"""Commands that measure frames."""
