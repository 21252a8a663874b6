"""The model against the measurement: one likelihood from the state of each shot to its poses."""
