"""Files that are broken on purpose: whether they are read, or refused in one sentence."""
