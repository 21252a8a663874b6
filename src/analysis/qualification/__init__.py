"""Accuracy runs with a known truth: stage, drop, disk and depth (thesis, 3.3, 4.2, 4.4, 6)."""
