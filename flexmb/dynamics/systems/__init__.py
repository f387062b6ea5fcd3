"""Systems: flows and maps, of mechanisms and of equations.

In: functions of a user, or a mechanism. Out: a present state that is advanced, alone or with tangents.
"""
