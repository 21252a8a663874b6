"""Sweeps: built, listed, watched and ordered."""
