"""The parts of `tools/benchmarks/planning.py`: its maps, its rivals, the reference, measuring and telling."""
