"""The sequence player of the leaderboard's page: its data, and the assets that show them."""
