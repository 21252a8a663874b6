"""From the settings of a shot to the spheres at the mouths of their tubes, and to first touch."""
