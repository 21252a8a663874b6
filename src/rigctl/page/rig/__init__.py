"""The rig as it is now, and orders to it."""
