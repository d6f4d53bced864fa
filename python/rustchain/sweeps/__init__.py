"""Many runs: sweeps, studies, loss maps."""
