"""The operator's page: what the routes answer, to look at and to act on, in a browser."""
