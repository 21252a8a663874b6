"""What looks at each request before a route does: keys, origins, lengths, connections."""
