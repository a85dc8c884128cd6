"""What a package outside of vbbench may add, each thing in one file, and the tests that take it from end to end."""
