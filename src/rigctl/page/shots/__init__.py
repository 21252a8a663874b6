"""Shots: listed, played, excluded or kept."""
