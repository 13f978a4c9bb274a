"""ArduCopter plug-in: profile, flight model, log format and simulated pilot."""
