"""Why a controller does what it does, one file a family: what :func:`leadscrew.operate.why.explainer` puts together."""
