"""Pictures, films and recordings of one sequence, and what a renderer must offer."""
