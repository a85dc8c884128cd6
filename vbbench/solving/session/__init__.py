"""Sessions: a solver on a live stream of boxes and odometry."""

from vbbench.solving.session.session import Session, SessionAnswer

__all__ = ["Session", "SessionAnswer"]
