"""Drive files: their models, reading, errors by position."""
