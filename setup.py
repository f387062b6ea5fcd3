"""What pyproject.toml cannot say: a wheel that carries compiled code is one for a platform and a version of Python.

`make wheel` compiles to the folder that FLEXMB_SHIPMENT names; where there is none the wheel is pure.
"""

import os
import shutil
from pathlib import Path

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

SHIPMENT = Path(os.environ.get("FLEXMB_SHIPMENT", "no shipment"))


class Carrier(Distribution):
    """A distribution that says whether it carries machine code."""

    def has_ext_modules(self) -> bool:
        """Whether its wheel is bound to a platform."""
        return SHIPMENT.is_dir()


class BuildWithShipment(build_py):
    """Puts the compiled code beside the sources."""

    def run(self) -> None:
        """Build the package."""
        super().run()
        if SHIPMENT.is_dir() and not self.editable_mode:
            target = Path(self.build_lib) / "flexmb" / "compiled" / "shipped"
            shutil.copytree(SHIPMENT, target, dirs_exist_ok=True)


setup(distclass=Carrier, cmdclass={"build_py": BuildWithShipment})
