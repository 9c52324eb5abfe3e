"""Gymnasium, Stable-Baselines3 and PettingZoo views of the game."""

from lazy_loader import attach_stub

from hexwar_sb3.envs.registration import register_envs

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)  # each name is imported when it is first used

register_envs()
