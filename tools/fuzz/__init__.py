"""Fuzz the readers and the link with damaged input, for any time."""
