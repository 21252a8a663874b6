"""Pictures of a tape from its digitised playback, each with its recorded number."""
