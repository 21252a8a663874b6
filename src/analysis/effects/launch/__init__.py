"""Effects of the launch: pushers, slide and tubes."""
