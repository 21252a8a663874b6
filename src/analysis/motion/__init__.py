"""From outlines and markers to poses, velocities and spins, in SI units and rig axes."""
