"""Which shots to fire next: settings that tell two effects apart, or sharpen a parameter."""
