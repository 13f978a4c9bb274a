"""PX4 multicopter plug-in."""
