"""Starts the node; topics are remapped and the parameters file is chosen on the command line."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

TOPICS = ("detections", "odom", "camera_info")


def generate_launch_description():
    """The node, with its arguments."""
    parameters = Path(get_package_share_directory("vbbench_ros")) / "config" / "birdifier.yaml"
    node = Node(
        package="vbbench_ros",
        executable="birdifier",
        name="birdifier",
        parameters=[LaunchConfiguration("parameters")],
        remappings=[(topic, LaunchConfiguration(topic)) for topic in TOPICS],
        output="screen",
    )
    arguments = [DeclareLaunchArgument(topic, default_value=topic) for topic in TOPICS]
    return LaunchDescription([DeclareLaunchArgument("parameters", default_value=str(parameters)), *arguments, node])
