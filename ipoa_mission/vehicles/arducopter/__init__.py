"""ArduCopter: what it is like, how it flies, and the pilot of its stand-in."""
