"""Heads that turn as people's do: ``look = natural`` and the laws that it draws from."""
