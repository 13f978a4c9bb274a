"""Define the command line; verbs import heavy modules when they run."""
