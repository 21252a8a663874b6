"""From grey levels to outlines and markers, in pixels (row, column); integer: pixel centre."""
