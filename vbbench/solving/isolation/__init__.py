"""Runs a solver in a process of its own that truth never reaches: not over its pipe, not in memory, not in files.

`process` is the side that holds truth, `child` the side that runs the solver. Between them go `messages`, arrays and
plain JSON that the first side checks; never pickles, which would let a solver run code where truth is. What the child
may read is listed by `grants` and kept to by the kernel (`landlock`); `kernels` gives it what numba has compiled.
"""
