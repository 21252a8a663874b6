"""One campaign's model: compare, where it fails, what is missing, add, next shots."""
