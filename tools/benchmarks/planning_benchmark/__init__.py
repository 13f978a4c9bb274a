"""Parts of `tools/benchmarks/planning.py`: maps, rivals, reference, measurement and tables."""
