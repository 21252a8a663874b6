"""Effects that are not in a fit, scored in one pass."""
