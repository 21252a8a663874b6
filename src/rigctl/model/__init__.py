"""Campaigns, their effects and next shots, as commands, jobs and the page ask for them."""

FUNCTIONS = "rigctl.model.computing"
"""Where the functions of jobs are: `<kind>_job` of each."""
