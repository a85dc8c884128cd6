"""What a stranger would add from outside: each file is one extension, registered by the test that uses it."""
