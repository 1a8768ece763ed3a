"""Methods: each makes controllers, and is registered in one line."""

from types import MappingProxyType

from core.methods.cross_entropy import CEM
from core.methods.dynamics_gradient import GRAD
from core.methods.f_mdp.method import F_MDP
from core.methods.method import Method
from core.methods.recurrent_ppo import RNN
from core.methods.tau_mdp import TAU_MDP
from core.methods.tgpo.method import TGPO, TGPO_STAR

METHODS: MappingProxyType[str, Method] = MappingProxyType(
    {method.name: method for method in (TGPO_STAR, TGPO, RNN, CEM, GRAD, TAU_MDP, F_MDP)}
)
"""The methods by name; the first is the default."""
