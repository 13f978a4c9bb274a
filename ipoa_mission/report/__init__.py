"""Pages, plots, tables and exports of flights."""
