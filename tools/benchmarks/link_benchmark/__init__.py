"""The parts of `tools/benchmarks/link.py`: vehicle, clients and their processes, rows, measuring and telling."""
