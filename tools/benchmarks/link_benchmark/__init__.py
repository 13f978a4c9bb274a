"""Parts of `tools/benchmarks/link.py`: vehicle, clients and their processes, rows, measurement and tables."""
