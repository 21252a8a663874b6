"""Tables of places that trackers write, and of times at which a ball was heard to bounce."""
