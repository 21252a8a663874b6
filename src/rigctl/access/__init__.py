"""Who may do what: keys with names and scopes, and what a key has to be."""
