"""The package `voz` of ROS 2: `ros2 run voz voz`, `ros2 launch voz voz.launch.py`.

It starts the program that `make ros2` has installed into the clone of voz that this folder is in.
"""

from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

CLONE = Path(__file__).resolve().parent.parent


class BuildWithPlace(build_py):
    """Keeps where the clone is: what is installed stands elsewhere."""

    def run(self) -> None:
        """Build, and write the place beside the program."""
        super().run()
        (Path(self.build_lib) / "voz_ros2" / "clone").write_text(f"{CLONE}\n")


setup(
    name="voz",
    version="0.1.0",
    packages=["voz_ros2"],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/voz"]),
        ("share/voz", ["package.xml"]),
        ("share/voz/launch", ["launch/voz.launch.py"]),
    ],
    install_requires=["setuptools"],
    zip_safe=False,
    author="The voz authors",
    author_email="voz@example.org",
    description="Offline voice control for robots: speak a command, the robot moves and answers.",
    license="Apache-2.0",
    entry_points={"console_scripts": ["voz = voz_ros2.program:main"]},
    cmdclass={"build_py": BuildWithPlace},
)
