"""Effects of the clock: when it shows what."""
