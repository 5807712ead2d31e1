"""Constant cutting force in turning with a grey-prediction fuzzy controller."""
