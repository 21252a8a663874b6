"""Accuracy runs with an apparatus of one's own: its frames from files, or recorded by its parts."""
