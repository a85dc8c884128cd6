"""Result files and dataset records: what they hold, their folder, and the ranks of a board's solvers."""
