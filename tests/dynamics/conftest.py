"""The tests of this folder share systems and mechanisms with known answers, which lie beside them."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
