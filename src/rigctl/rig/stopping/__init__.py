"""The emergency stop: what cuts, what watches, and what outlasts the process."""
