"""Every number of the game, checked and hashed, and the pure look-ups in its tables."""

from hexwar_sb3.rules.adjudicate import adjudicate
from hexwar_sb3.rules.enums import Action, Camp, Dice, HopClass, PieceType, TargetClass, Weapon
from hexwar_sb3.rules.ruleset import RuleSet, default_rules

__all__ = [
    "Action",
    "Camp",
    "Dice",
    "HopClass",
    "PieceType",
    "RuleSet",
    "TargetClass",
    "Weapon",
    "adjudicate",
    "default_rules",
]
