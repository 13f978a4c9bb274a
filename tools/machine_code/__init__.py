"""Compile the machine code of a wheel: `python -m tools.machine_code FOLDER` (see `ipoa_mission.compiled`)."""
