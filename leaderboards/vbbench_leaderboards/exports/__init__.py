"""Boards as files for papers and programs: CSV, JSON, Markdown, LaTeX, and what to cite as BibTeX."""
