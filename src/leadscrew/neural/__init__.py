"""Networks that learn: performance measurement, fuzzy inference."""
