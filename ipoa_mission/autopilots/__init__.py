"""Each autopilot's own facts, once: parameters and defaults, modes, storage, touchdown."""
