"""Results of runs: arrays, views of their parts, tables, files."""
