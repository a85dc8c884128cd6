"""Off-screen pictures of scenes. Renderers register under the entry point group ``vbbench.renderers``."""
