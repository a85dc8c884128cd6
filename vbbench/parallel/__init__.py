"""Long work in resumable parts, in several processes or on a cluster, with the same bytes."""
