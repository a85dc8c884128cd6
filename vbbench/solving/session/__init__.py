"""A solver on a robot: boxes and odometry go in as they are measured, poses and positions come out, without an end."""

from vbbench.solving.session.session import Session, SessionAnswer

__all__ = ["Session", "SessionAnswer"]
