"""Campaigns: listed, shown, reported."""
