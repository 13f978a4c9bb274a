"""PX4 multicopter plug-in: profile, flight model, log format and simulated pilot."""
