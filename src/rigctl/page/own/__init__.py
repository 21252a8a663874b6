"""Data that somebody brings: films of a ball and campaign folders, measured and compared."""
