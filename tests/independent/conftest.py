"""Lets the files of this folder import `slider_crank`."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
