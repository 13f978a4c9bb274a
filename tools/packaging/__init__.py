"""What is made when a wheel is built."""
