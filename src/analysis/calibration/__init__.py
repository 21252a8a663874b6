"""Camera parameters estimated from the shots of a campaign."""
