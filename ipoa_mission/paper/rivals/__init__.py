"""The algorithms that the paper compares IPOA with, registered as optimizers by entry points."""
