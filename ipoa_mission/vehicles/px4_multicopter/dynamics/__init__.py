"""PX4 1.13 to 1.18, multicopter: what is asked of it (`Order`), how it moves (`step`), and a whole flight (`fly`)."""
