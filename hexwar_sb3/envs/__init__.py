"""Gymnasium, Stable-Baselines3 and PettingZoo views of the game."""

from hexwar_sb3.envs.registration import register_envs

register_envs()
