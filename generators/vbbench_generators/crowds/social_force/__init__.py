"""The crowd engine: the social force model, many scenes side by side, compiled."""
