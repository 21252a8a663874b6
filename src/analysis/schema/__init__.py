"""Documents that others read: each defined once, as a frozen model equal to its JSON."""
