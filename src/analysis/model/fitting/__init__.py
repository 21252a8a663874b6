"""Fits of a campaign: each shot's own numbers eliminated, what is shared fitted jointly."""
