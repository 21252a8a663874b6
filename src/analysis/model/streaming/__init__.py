"""Campaigns of any length, fitted and ranked in the memory that a short one takes.

Poses and the shots' own numbers lie in temporary files and are gone over so many shots at a time;
sums alone stay in memory, and some tens of bytes a shot.
"""
