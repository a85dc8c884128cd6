"""Long work in resumable parts, in several processes or on a cluster; the result's bytes do not depend on these."""
