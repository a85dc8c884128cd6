"""The motion prior at work: how walks and heads go on, as the kernels take it, and what a sequence teaches of it."""
