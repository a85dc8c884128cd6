"""Challenges: an organiser keeps the truth of one secret set, teams hand in answers, phases open and close by date."""
