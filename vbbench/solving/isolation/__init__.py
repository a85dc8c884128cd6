"""Runs a solver in a separate process that truth never reaches: not over its pipe, not in memory, not in files.

`remote` is the side that holds truth, `confinement` and `serving` the side that runs the solver.
Between them go `messages`, arrays and plain JSON that the first side checks; never pickles, which would let a solver
run code where truth is. What the solver may read is listed by `grants`.
"""
