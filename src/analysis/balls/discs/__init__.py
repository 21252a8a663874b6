"""Discs of any size in one picture, grey or colour, each with a number of false alarms."""
