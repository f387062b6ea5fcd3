"""Pictures, films and pages of runs, diagrams and motions.

In: solutions and data sets. Out: figures, files, HTML. Heavy packages are imported when a picture is asked for.
"""
