"""Implement the algorithms that the paper compares IPOA with; entry points register them as optimizers."""
