"""Effects of the camera: where it shows what."""
