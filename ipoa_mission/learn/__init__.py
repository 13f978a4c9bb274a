"""Learn one vehicle's differences from the simulated one."""
