"""Other programs' files and detectors: MOTChallenge, TUM, CSV, recordings of heads."""
