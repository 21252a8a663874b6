"""Campaigns, their effects and next shots, as commands, jobs and the page ask for them."""
