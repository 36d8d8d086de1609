"""Inverse velocity: joint rates for a twist, by choice of law, within limits, in order of priority. Floor 8.

Reads Jacobians only. One law or helper per module; the names below are the public ones.
"""

from .limits import RateLimits
from .methods import joint_rates
from .priority import PrioritizedRates, prioritized_rates
from .result import JointRates
from .solver import RateSolver

__all__ = ["JointRates", "PrioritizedRates", "RateLimits", "RateSolver", "joint_rates", "prioritized_rates"]
