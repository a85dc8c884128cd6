"""The pages of the leaderboard: HTML written here, arranged in the browser by the plain scripts in ``assets``."""
