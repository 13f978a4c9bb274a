"""ArduCopter plug-in."""
