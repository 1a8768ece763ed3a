"""Methods: each makes controllers, and is registered in one line."""

from types import MappingProxyType

from core.methods.method import Method
from core.methods.tgpo.method import TGPO, TGPO_STAR

METHODS: MappingProxyType[str, Method] = MappingProxyType(
    {method.name: method for method in (TGPO_STAR, TGPO)}
)
"""The methods by name; the first is the default."""
