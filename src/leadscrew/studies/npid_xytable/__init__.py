"""Nonlinear PID of an XY table under cutting forces (L. Abdullah et al.)."""
