"""From the module's trees to C99: the third printer, beside plain Python and machine code."""
