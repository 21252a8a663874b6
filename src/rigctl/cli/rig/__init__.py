"""Commands that run the rig, and the demonstration."""
