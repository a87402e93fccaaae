"""PyTorch Geometric as the networks use it, without two things that only compiled code needs.

Its import loads torch's compiler to recognise compiled modules (1.6 of 2.0 s of CPU), and each
layer writes its TorchScript source to the temporary folder and leaves it there.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType

_COMPILER = "torch._dynamo"


class _StandIn(ModuleType):
    """A module that is imported when a name of it is asked for."""

    def __getattr__(self, name: str) -> object:
        if sys.modules.get(self.__name__) is self:
            del sys.modules[self.__name__]
        return getattr(import_module(self.__name__), name)


_stand_in = _StandIn(_COMPILER)
sys.modules.setdefault(_COMPILER, _stand_in)
try:
    from torch_geometric.data import Data
    from torch_geometric.nn import GatedGraphConv, MessagePassing
finally:  # whoever asks torch for its compiler from here on gets it
    if sys.modules.get(_COMPILER) is _stand_in:
        del sys.modules[_COMPILER]


class WithoutTemplates:
    """Keeps a layer from writing its TorchScript source."""

    def _set_jittable_templates(self, raise_on_error: bool = False) -> None:
        """Leave the layer's methods as they are."""


__all__ = ["Data", "GatedGraphConv", "MessagePassing", "WithoutTemplates"]
