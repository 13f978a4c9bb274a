"""Generate files of the repository: maps, tables, references."""
