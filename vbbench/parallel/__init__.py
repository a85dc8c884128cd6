"""Long work: in parts, in several processes, on a cluster, stopped and resumed, with the same bytes."""
