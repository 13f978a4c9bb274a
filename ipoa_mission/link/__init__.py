"""How to tell the vehicle: the MAVLink mission services, without losing an item."""
