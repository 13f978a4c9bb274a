"""The parts of the report's page, one file each; every one returns HTML that is complete without a script."""
