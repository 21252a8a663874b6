"""Frames from files of every form that is read."""
