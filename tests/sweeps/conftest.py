"""The functions of these tests are in a module that worker processes can import."""

import os
import sys
from pathlib import Path

FOLDER = str(Path(__file__).parent)
sys.path.insert(0, FOLDER)
ROOT = str(Path(__file__).parents[2])
os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [FOLDER, ROOT, os.environ.get("PYTHONPATH")]))
