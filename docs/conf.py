"""Settings of the site (`make site`)."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import api_pages

from flexmb.version import installed_version

project = "flexmb"
author = "flexmb developers"
release = installed_version()
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.viewcode", "sphinx.ext.mathjax", "equations"]
exclude_patterns = ["_build"]

nb_execution_timeout = 600
nb_execution_raise_on_error = True
nb_mime_priority_overrides = [("html", "application/vnd.jupyter.widget-view+json", None)]  # players instead
nb_ipywidgets_js = {}  # without a network

html_theme = "furo"
html_title = f"flexmb {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_search_summary = False  # texts of pages cannot be read from a disk, and the search works there without them
html_show_copyright = False
html_theme_options = {"navigation_with_keys": True}

myst_enable_extensions = ["dollarmath", "html_image"]
myst_heading_anchors = 4
suppress_warnings = ["myst.header"]

autodoc_typehints = "none"
autodoc_member_order = "bysource"
toc_object_entries_show_parents = "hide"

api_pages.write()
