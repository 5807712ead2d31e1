"""The circular test (double ball bar) in the sense of ISO 230-4: quantities, reversal peaks, diagnosis, instrument.

=============================================  =============================================================
:mod:`leadscrew.analysis.circular.paths`       a turn, the test that it belongs to, the least-squares circle
:mod:`leadscrew.analysis.circular.quantities`  G, G(b), F, D, H, by edition of the standard
:mod:`leadscrew.analysis.circular.reversals`   quadrant glitches: height, step and duration
:mod:`leadscrew.analysis.circular.signatures`  what each fault of a machine draws
:mod:`leadscrew.analysis.circular.diagnosis`   which faults a circle shows, and how much of each
:mod:`leadscrew.analysis.circular.synthetic`   circles with known faults, and what a ball bar would read
:mod:`leadscrew.analysis.circular.simulation`  a loop draws a circle: one loop of two axes, or two of one
:mod:`leadscrew.analysis.circular.file`        measured circles from a CSV file
:mod:`leadscrew.analysis.circular.recording`   the turns of a recording in time: rest, ramps and feed-in left out
:mod:`leadscrew.analysis.circular.jumps`       encoder jumps
:mod:`leadscrew.analysis.circular.evaluation`  all of it for one test
=============================================  =============================================================

The text of the standard was not at hand: definitions follow its public abstracts and summaries. For an acceptance test,
hold them against your copy.
"""
