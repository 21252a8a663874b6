"""The routes of REST, by subject."""
