"""JRDB: a robot with a 360° camera among people, indoors and outdoors (Martín-Martín et al. 2021)."""
