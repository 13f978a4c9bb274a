"""Makes the machine code that a wheel carries: `python -m tools.machine_code FOLDER` (see `ipoa_mission.compiled`)."""
