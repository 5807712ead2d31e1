"""Grey prediction: models of very few samples, as step functions for a loop and over arrays, one file each.

The step functions (:mod:`~leadscrew.grey.window`, :mod:`~leadscrew.grey.gm11`, :mod:`~leadscrew.grey.others`,
:mod:`~leadscrew.grey.predictors`) hold five samples and are compiled with the controller that calls them. The same
models for windows of any length are in :mod:`leadscrew.grey.vectorised`.
"""
