"""A module that must never be imported: only strangers' files name it."""

raise RuntimeError("a module that a stranger's file names was imported")
