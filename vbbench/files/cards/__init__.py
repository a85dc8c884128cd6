"""The cards of a dataset: ``README.md`` for people and hubs, ``croissant.json`` for programs."""
