"""The figure of posteriors: how sure the observer's pose is, by how many people walk around it and how they walk."""
