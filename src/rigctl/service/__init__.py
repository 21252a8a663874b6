"""REST: routes, authentication, problems and events."""
