"""Runs a solver in a separate process without access to truth: over its pipe, in memory, or in files.

`remote` is the side with truth, `confinement` and `serving` the side of the solver. They exchange messages of arrays
and plain JSON, which the first side checks; pickles would let a solver run code on the side with truth.
"""
