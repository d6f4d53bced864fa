"""Wrong values of every field, and how a refusal of one reads."""
