"""PX4 1.13 to 1.18, multicopter: orders (`Order`), one step (`step`), and a whole flight (`fly`)."""
