"""Read flights from logs, and learn a vehicle from them."""
