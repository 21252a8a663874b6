"""Commissioning: what a person must have seen of a real rig before it fires."""
