"""Shots: listed, played, judged."""
