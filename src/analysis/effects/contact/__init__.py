"""Effects of the contact: what the hard-sphere law leaves out."""
