"""The views of observers in a scene: poses of a carried camera, and people's boxes."""
