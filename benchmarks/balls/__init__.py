"""Films of dropped balls, drawn by ray tracing, and how well they are measured."""
