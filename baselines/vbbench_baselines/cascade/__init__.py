"""The stages and terms of the paper's cascade: learned heights, the pose under robust norms, and the crowd graph."""
