"""`rigctl model`: a campaign's poses against the model, and the effects that it may lack."""
