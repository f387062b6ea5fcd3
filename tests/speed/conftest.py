"""The models of this folder are imported by name, here and from docs/performance.py."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))


collect_ignore = ["nine_bar_statistics.py", "peer.py", "peer_link.py", "peer_nine_bar.py", "rows.py"]
"""Modules that import the peer, which need not be installed; pytest looks for examples in every module."""
