"""Vehicle plug-ins, found by the entry points `ipoa_mission.vehicles`."""
