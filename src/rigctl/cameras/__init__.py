"""Frame sources and the capture of a shot."""
