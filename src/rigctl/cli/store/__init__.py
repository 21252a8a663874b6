"""Commands on stored shots and campaigns."""
