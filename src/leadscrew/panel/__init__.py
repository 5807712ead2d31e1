"""The operator panel: a machine watched and tuned in the browser."""
