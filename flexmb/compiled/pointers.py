"""Addresses of kernels, as compiled code calls them."""

from __future__ import annotations

from typing import Any

from numba import types
from numba.core import cgutils, typing
from numba.core.datamodel import models
from numba.core.imputils import lower_builtin
from numba.extending import register_model


class KernelPointer(types.Callable, types.Opaque):
    """numba's type of the address of a kernel, which is called directly.

    numba's own first-class functions ask at every call whether there is an address, and else call Python.

    Parameters
    ----------
    name : of the contract.
    signature : numba's signature of its kernels.
    """

    def __init__(self, name: str, signature: Any) -> None:
        self.signature = signature
        super().__init__(f"kernel_{name}")

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:  # noqa: ARG002 - as numba asks
        """The signature of the contract, whatever is given."""
        return typing.signature(self.signature.return_type, *self.signature.args, recvr=self)

    def get_call_signatures(self) -> Any:
        """The signature of the contract."""
        return (self.signature,), False

    def get_impl_key(self, sig: Any) -> Any:  # noqa: ARG002 - as numba asks
        """Key of the registration of `_call_kernel`."""
        return KernelPointer


register_model(KernelPointer)(models.OpaqueModel)


@lower_builtin(KernelPointer, types.VarArg(types.Any))
def _call_kernel(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    kinds = signature.args[1:]
    kind = context.call_conv.get_function_type(signature.return_type, kinds)
    function = builder.bitcast(arguments[0], kind.as_pointer())
    status, result = context.call_conv.call_function(builder, function, signature.return_type, kinds, arguments[1:])
    with cgutils.if_unlikely(builder, status.is_error):
        context.call_conv.return_status_propagate(builder, status)
    return result
