"""Families of recordings on which every solver is judged, against the naive ``ground-plane``; see ``__main__``."""
