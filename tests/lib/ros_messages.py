"""Messages of ROS 1 and 2 as rosbags makes them, for bags that tests write."""

from typing import Any

import numpy as np


class Messages:
    """Makes messages of a type store; times count from ``start``, in seconds."""

    def __init__(self, ros: int, start: float) -> None:
        from rosbags.typesys import Stores, get_typestore

        self.ros, self.start = ros, start
        self.store = get_typestore(Stores.ROS1_NOETIC if ros == 1 else Stores.ROS2_HUMBLE)

    def make(self, kind: str, **fields: Any) -> Any:
        return self.store.types[kind](**fields)

    def nanoseconds(self, time: float) -> int:
        return round((self.start + time) * 1e9)

    def header(self, time: float) -> Any:
        seconds, rest = divmod(self.nanoseconds(time), 10**9)
        stamp = self.make("builtin_interfaces/msg/Time", sec=seconds, nanosec=rest)
        number = {"seq": 0} if self.ros == 1 else {}
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id="camera", **number)

    def vector(self, x: float = 0.0, z: float = 0.0) -> Any:
        return self.make("geometry_msgs/msg/Vector3", x=x, y=0.0, z=z)

    def turned(self, yaw: float) -> Any:
        return self.make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=np.sin(yaw / 2), w=np.cos(yaw / 2))

    def pose(self, x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> Any:
        place = self.make("geometry_msgs/msg/Point", x=x, y=y, z=0.0)
        pose = self.make("geometry_msgs/msg/Pose", position=place, orientation=self.turned(yaw))
        return self.make("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=np.zeros(36))

    def odometry(self, time: float, pose: Any, speed: float = 0.0, turn: float = 0.0) -> Any:
        """A pose (x, y, yaw), a speed ahead in m/s and a turn in rad/s."""
        twist = self.make("geometry_msgs/msg/Twist", linear=self.vector(x=speed), angular=self.vector(z=turn))
        return self.make(
            "nav_msgs/msg/Odometry",
            header=self.header(time),
            child_frame_id="base_link",
            pose=self.pose(*(float(value) for value in pose)),
            twist=self.make("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=np.zeros(36)),
        )

    def imu(self, time: float, turn: float, up: float = 1.0) -> Any:
        """A turn in rad/s of a sensor that lies as it should, or upside down."""
        spread = np.zeros(9)
        return self.make(
            "sensor_msgs/msg/Imu",
            header=self.header(time),
            orientation=self.turned(0.0),
            orientation_covariance=spread,
            angular_velocity=self.vector(z=up * turn),
            angular_velocity_covariance=spread,
            linear_acceleration=self.vector(z=up * 9.81),
            linear_acceleration_covariance=spread,
        )
