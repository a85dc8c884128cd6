"""Splits of recordings: camera, boxes and people's places as data sets publish them, or as users have them.

Every reader raises FileError at the first thing that is wrong: it names the file, the line or row, and what to do.
"""
