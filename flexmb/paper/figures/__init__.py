"""The figures of the study.  Each module has a function `plates(effort)`; `contents.py` lists the modules."""
