"""Export of drives for co-simulation by the Functional Mock-up Interface (FMI)."""
