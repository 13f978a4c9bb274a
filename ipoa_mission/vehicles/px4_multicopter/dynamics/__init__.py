"""PX4 1.13 to 1.18, multicopter: orders, one step, whole flights."""
