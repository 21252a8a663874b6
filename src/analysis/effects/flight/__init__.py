"""Effects of the free flight."""
