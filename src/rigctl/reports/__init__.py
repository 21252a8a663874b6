"""The report of a campaign: one HTML file with the results and all that reproduces them."""
