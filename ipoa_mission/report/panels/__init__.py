"""The parts of the report's page, one file each; each returns HTML that is complete without a script."""
