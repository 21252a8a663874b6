"""`rigctl model`: a campaign's poses against the model, and the effects it would rather have."""
