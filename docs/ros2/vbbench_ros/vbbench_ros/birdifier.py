"""The node: boxes of a tracker and odometry come in, the robot's pose and the people around it go out.

Axes are those of REP 103, frames those of REP 105: map to odom is corrected, odom to base_link is the robot's own.
"""

from collections import deque

import numpy as np
import rclpy
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo
from tf2_ros import TransformBroadcaster
from vision_msgs.msg import Detection2DArray, Detection3D, Detection3DArray, ObjectHypothesisWithPose

from vbbench import OdometryFacts, PerspectiveCamera, Session, VbbenchError
from vbbench.geometry import covariance_along, pose_levers, wrap_angle

PARAMETERS = {
    "solver": "map-causal",
    "dt": 0.1,
    "person_class": "person",
    "mount_height": 1.2,
    "pitch": 0.0,
    "roll": 0.0,
    "mount": [0.0, 0.0, 0.0],
    "carried_by": "robot",
    "pixel_std": 2.0,
    "box_std": 0.03,
    "tilt_std": 0.03,
    "mount_height_std": 0.0,
    "height_mean": 1.72,
    "height_std": 0.09,
    "odometry_distance": 0.05,
    "odometry_sideways": 0.02,
    "odometry_turn": 0.05,
    "longest_gap": 60.0,
    "map_frame": "map",
    "odom_frame": "odom",
    "publish_tf": True,
}
ERRORS = ("carried_by", "pixel_std", "box_std", "tilt_std", "mount_height_std", "height_mean", "height_std")


class Birdifier(Node):
    """A session on the messages of a robot."""

    def __init__(self):
        super().__init__("birdifier")
        self.facts = {name: self.declare_parameter(name, value).value for name, value in PARAMETERS.items()}
        noise = {name: self.facts[f"odometry_{name}"] for name in ("distance", "sideways", "turn")}
        self.wheels = OdometryFacts(mount=tuple(self.facts["mount"]), **noise)
        self.session = None  # until the camera is known
        self.answered, self.time = None, None  # odometry and time of the last frame that was answered
        self.driven = deque(maxlen=2000)  # time, x, y, yaw of the base
        self.create_subscription(CameraInfo, "camera_info", self.on_camera, 1)
        self.create_subscription(Odometry, "odom", self.on_odometry, 100)
        self.create_subscription(Detection2DArray, "detections", self.on_frame, 10)
        self.pose = self.create_publisher(PoseWithCovarianceStamped, "pose", 10)
        self.people = self.create_publisher(Detection3DArray, "people", 10)
        self.frames = TransformBroadcaster(self) if self.facts["publish_tf"] else None

    def on_camera(self, info):
        """Begin the session with the first calibration: P is of the rectified picture, as the boxes are."""
        if self.session is not None or not info.p[0] > 0.0:
            return
        picture = {"width": info.width, "height": info.height, "focal": info.p[0], "vertical_focal": info.p[5]}
        tilt = {name: self.facts[name] for name in ("mount_height", "pitch", "roll")}
        camera = PerspectiveCamera(**picture, cx=info.p[2], cy=info.p[6], **tilt)
        self.session = Session(
            self.facts["solver"], camera, self.facts["dt"], **{name: self.facts[name] for name in ERRORS}
        )

    def on_odometry(self, odometry):
        """Keep a pose of the base: detections are late, and their odometry is looked up."""
        time, pose = seconds(odometry.header.stamp), odometry.pose.pose
        q = pose.orientation
        yaw = np.arctan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y**2 + q.z**2))
        if self.driven and time <= self.driven[-1][0]:
            if time > self.driven[-1][0] - 1.0:
                return  # twice, or out of order
            self.driven.clear()  # the clock was set back
        if self.driven:
            yaw = self.driven[-1][3] + wrap_angle(yaw - self.driven[-1][3])
        self.driven.append((time, pose.position.x, pose.position.y, yaw))

    def base_at(self, time):
        """Where the base was by odometry; None where there is none of that time."""
        known = np.array(self.driven).reshape(-1, 4)
        if len(known) == 0 or not known[0, 0] <= time <= known[-1, 0]:
            return None
        return np.array([np.interp(time, known[:, 0], known[:, n]) for n in (1, 2, 3)])

    def on_frame(self, detections):
        """Step the session, and publish its answer."""
        if self.session is None:
            self.get_logger().warning("no camera_info with a calibration P came yet: a frame is left out")
            return
        time = seconds(detections.header.stamp)
        if self.time is not None and not -1.0 < time - self.time < self.facts["longest_gap"]:
            self.get_logger().warning(f"the clock went from {self.time:.3f} to {time:.3f} s: a new map begins")
            self.session.reset()
            self.answered = None
        now = self.base_at(time)
        known = now is not None and self.answered is not None
        moved = self.wheels.motion(self.answered, now, abs(time - self.time)) if known else None
        try:
            answer = self.session.step(self.boxes(detections), moved, time=time)
        except VbbenchError as error:
            self.get_logger().warning(str(error))
            return
        self.answered, self.time = now, time
        self.publish_pose(answer, detections.header.stamp)
        self.publish_people(answer, detections.header.stamp)

    def boxes(self, detections):
        """Boxes of people by the tracker's ids."""
        return [
            (found.id, (middle.x - found.bbox.size_x / 2, middle.y - found.bbox.size_y / 2, *size(found.bbox)))
            for found in detections.detections
            for middle in [found.bbox.center.position]
            if found.id and any(r.hypothesis.class_id == self.facts["person_class"] for r in found.results)
        ]

    def publish_pose(self, answer, stamp):
        """The base in the map, and where the map puts the frame of odometry."""
        base = carrier(answer.pose, self.facts["mount"])
        message = PoseWithCovarianceStamped()
        message.header.stamp, message.header.frame_id = stamp, self.facts["map_frame"]
        place(message.pose.pose.position, message.pose.pose.orientation, base)
        if answer.pose_covariance is not None:
            spread = covariance_along(pose_levers(base, answer.pose), answer.pose_covariance)
            covariance = np.zeros((6, 6))
            covariance[np.ix_([0, 1, 5], [0, 1, 5])] = spread
            message.pose.covariance = covariance.ravel().tolist()
        self.pose.publish(message)
        if self.frames is not None and self.answered is not None:
            corrected = TransformStamped()
            corrected.header, corrected.child_frame_id = message.header, self.facts["odom_frame"]
            transform = corrected.transform
            place(transform.translation, transform.rotation, carrier(base, self.answered))
            self.frames.sendTransform(corrected)

    def publish_people(self, answer, stamp):
        """Everybody seen in this frame, as an upright box with the tracker's id."""
        people = Detection3DArray()
        people.header.stamp, people.header.frame_id = stamp, self.facts["map_frame"]
        for track, (x, y) in answer.positions.items():
            person, found = Detection3D(), ObjectHypothesisWithPose()
            height = answer.heights.get(track, self.facts["height_mean"])
            person.header, person.id = people.header, str(track)
            found.hypothesis.class_id, found.hypothesis.score = self.facts["person_class"], 1.0
            for position in (person.bbox.center.position, found.pose.pose.position):
                position.x, position.y, position.z = float(x), float(y), height / 2
            person.bbox.size.x, person.bbox.size.y, person.bbox.size.z = 0.5, 0.5, height
            if track in answer.position_covariances:
                covariance = np.zeros((6, 6))
                covariance[:2, :2] = answer.position_covariances[track]
                found.pose.covariance = covariance.ravel().tolist()
            person.results = [found]
            people.detections.append(person)
        self.people.publish(people)


def seconds(stamp):
    """The time of a stamp."""
    return stamp.sec + 1e-9 * stamp.nanosec


def size(bbox):
    """Width and height of a box."""
    return bbox.size_x, bbox.size_y


def carrier(pose, mount):
    """The pose (x, y, yaw) of what carries something at ``mount`` (forward, left, yaw), whose pose is known."""
    yaw = pose[2] - mount[2]
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.array([pose[0] - cos * mount[0] + sin * mount[1], pose[1] - sin * mount[0] - cos * mount[1], yaw])


def place(position, orientation, pose):
    """Write a pose (x, y, yaw) into a message."""
    position.x, position.y = float(pose[0]), float(pose[1])
    orientation.z, orientation.w = float(np.sin(pose[2] / 2)), float(np.cos(pose[2] / 2))


def main():
    """Run the node until it is stopped."""
    rclpy.init()
    rclpy.spin(Birdifier())
