"""The routes of REST, by what they are about."""
