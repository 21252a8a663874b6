"""Effects that a user wrote: read from a folder, tried before use, watched while in use."""
