"""The command `rustchain`."""
