"""PX4 1.13 to 1.18 on a multicopter: one folder is the whole plug-in, with the files of `arducopter`."""
