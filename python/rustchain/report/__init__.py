"""Reports: one page with inputs, key figures, safety, plots and the player."""
