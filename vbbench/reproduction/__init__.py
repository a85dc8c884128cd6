"""The paper's tables and figures, made again from nothing: data, solving, scoring, and the picture."""
