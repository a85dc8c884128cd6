"""What makes a release: the version, the notes, and the words that are true before it and after it."""
