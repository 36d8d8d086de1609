"""Inverse velocity: joint rates for a twist, by choice of law, within limits, in order of priority. Floor 8.

And the two motions they add up to: a tip that is pulled, and an arm that moves while its tip stands still. The laws read
Jacobians only. One law or helper per module; the names below are the public ones.
"""

from .limits import RateLimits
from .methods import joint_rates
from .priority import PrioritizedRates, prioritized_rates
from .result import JointRates
from .self_motions import SelfMotion, self_motion
from .solver import RateSolver
from .tip_motion import TipMotion, move_tip

__all__ = [
    "JointRates",
    "PrioritizedRates",
    "RateLimits",
    "RateSolver",
    "SelfMotion",
    "TipMotion",
    "joint_rates",
    "move_tip",
    "prioritized_rates",
    "self_motion",
]
