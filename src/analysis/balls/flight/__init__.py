"""Free flight between bounces, as a camera sees it, fitted to the places of a ball."""
