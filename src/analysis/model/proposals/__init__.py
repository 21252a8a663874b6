"""Laws that no catalogue holds: what depends on what, proposed from what a fit leaves over."""
