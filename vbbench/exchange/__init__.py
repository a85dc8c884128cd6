"""Data of other tools, in and out: boxes, trajectories, camera files, MOTChallenge and TUM folders, CSV.

Every reader raises FileError at the first thing that is wrong: it names the file, the line, and what to write instead.
Options that cannot be, withheld truth and a folder in the way are a VbbenchError.
"""
