"""Every public name of flexmb: those at the top and those of its namespaces."""

import types
from typing import Any

import flexmb

NAMESPACES = sorted(name for name in flexmb.__all__ if isinstance(getattr(flexmb, name), types.ModuleType))
"""Public modules of the package."""

PUBLIC: dict[str, Any] = {
    **{name: getattr(flexmb, name) for name in flexmb.__all__ if name not in NAMESPACES},
    **{
        f"{space}.{name}": getattr(getattr(flexmb, space), name)
        for space in NAMESPACES
        for name in getattr(flexmb, space).__all__
    },
}
"""Objects by their names behind `flexmb.`; a name at the top may stand in a namespace, too."""

BY_LAST_NAME: dict[str, Any] = {name.rpartition(".")[2]: value for name, value in PUBLIC.items()}
"""The same objects by their last names."""
