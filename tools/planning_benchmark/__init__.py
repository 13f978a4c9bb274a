"""The parts of `tools/benchmark_planning.py`: its maps, its rivals, the reference, measuring and telling."""
