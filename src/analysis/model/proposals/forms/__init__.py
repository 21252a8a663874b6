"""Forms of a law: what depends on what, and in which shape."""
