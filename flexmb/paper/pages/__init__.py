"""The tables of the study.  Each module has a function `pages(effort)`; `contents.py` lists the modules."""
