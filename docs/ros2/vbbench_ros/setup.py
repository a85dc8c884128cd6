"""How colcon builds the package; vbbench itself is installed by pip."""

from setuptools import setup

NAME = "vbbench_ros"

setup(
    name=NAME,
    version="1.0.0",
    packages=[NAME],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", ["launch/birdifier.launch.py"]),
        (f"share/{NAME}/config", ["config/birdifier.yaml"]),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    maintainer="The vbbench developers",
    description="Localises a robot and the people around it from the boxes of a tracker",
    license="Apache-2.0",
    entry_points={"console_scripts": [f"birdifier = {NAME}.birdifier:main"]},
)
