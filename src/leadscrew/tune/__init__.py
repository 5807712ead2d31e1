"""Search and uncertainty: distributions over parameters, many runs anywhere, tuning, comparison, Monte Carlo."""
