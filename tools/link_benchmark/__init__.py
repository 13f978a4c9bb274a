"""The parts of `tools/benchmark_link.py`: the vehicle, the clients and their processes, rows, measuring and telling."""
