"""How a sphere looks in a frame, and a frame's normal equations for its pose."""
