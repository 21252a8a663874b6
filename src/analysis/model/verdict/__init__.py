"""From scores to a verdict, in words and documents."""
