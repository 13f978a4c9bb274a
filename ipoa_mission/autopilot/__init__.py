"""Interface of vehicle plug-ins: parameters, modes, firmware tables, commands, energy."""
