"""From a user's recording to a map: poses, positions, pictures, and a report of their uncertainty."""
