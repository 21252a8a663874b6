"""Devices by role, over transports that know only bytes and lines."""
