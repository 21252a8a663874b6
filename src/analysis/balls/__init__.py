"""Unmarked balls in any film: files, finding, following, flights between bounces, results."""
