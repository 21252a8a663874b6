"""The way of somebody who is here for the first time, from an empty store to a verdict."""
