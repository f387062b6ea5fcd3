"""The models of this folder are imported by name, here and from docs/performance.py."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
