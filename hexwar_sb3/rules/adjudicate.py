"""One shot looked up in the tables of section 7, in plain Python: what a referee does by hand."""

from __future__ import annotations

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.rules.check import MAX_ARMOUR, MAX_BLOOD, MAX_LEVEL
from hexwar_sb3.rules.compiled import NO_EFFECT
from hexwar_sb3.rules.enums import TargetClass
from hexwar_sb3.rules.ruleset import RuleSet, default_rules

DESTROYED = 1  # an aerocraft has 1 blood


def adjudicate(
    target_class: TargetClass | str,
    level: int,
    shooter_blood: int,
    armour: int,
    roll1: int,
    roll2: int,
    modifiers: int,
    *,
    small_arms: bool = False,
    rules: RuleSet | None = None,
) -> int:
    """Result of one direct or guided shot (rule book, section 7).

    Args:
        target_class: what is shot at, or its name: "vehicle", "soldier", "aerocraft".
        level: attack level after the height correction, 1..10.
        shooter_blood: blood of the shooter, 1..5; it counts against vehicles.
        armour: of the target, 0 none .. 4 composite; it counts for vehicles.
        roll1: two dice, 2..12.
        roll2: the correction's dice: two, 2..12, for vehicles; one, 1..6, for soldiers; none for aerocraft.
        modifiers: sum of the shot's modifiers, added to `roll2`.
        small_arms: the weapon is SMALL, which reads the soldier table against vehicles too.
        rules: the rule set; the rule book's by default.

    Returns:
        -1 nothing, 0 suppressed, n >= 1 losses before they are capped at the target's blood.

    Raises:
        ConfigError: an argument is out of its range.

    Example:
        >>> adjudicate("vehicle", level=8, shooter_blood=3, armour=2, roll1=7, roll2=12, modifiers=-2)
        4
    """
    rules = default_rules() if rules is None else rules
    kind = _target_class(target_class)
    _check("level", level, 1, MAX_LEVEL)
    _check("shooter_blood", shooter_blood, 1, MAX_BLOOD)
    _check("armour", armour, 0, MAX_ARMOUR)
    _check("roll1", roll1, 2, 12)
    if kind == TargetClass.AEROCRAFT:
        return DESTROYED if level >= rules.table("air_kill_level").at(roll1) else NO_EFFECT
    _check("roll2", roll2, *((2, 12) if kind == TargetClass.VEHICLE else (1, 6)))
    raw = _raw_result(rules, kind, level, shooter_blood, roll1, small_arms=small_arms)
    return max(NO_EFFECT, raw + _correction(rules, kind, armour, roll2 + modifiers))


def _raw_result(
    rules: RuleSet, kind: TargetClass, level: int, shooter_blood: int, roll: int, *, small_arms: bool
) -> int:
    if kind == TargetClass.SOLDIER or small_arms:
        return rules.table("soldier_result").at(roll, level)
    column = rules.table("column").at(shooter_blood, level)
    return rules.table("vehicle_result").at(roll, column)


def _correction(rules: RuleSet, kind: TargetClass, armour: int, corrected_roll: int) -> int:
    if kind == TargetClass.SOLDIER:
        return rules.table("soldier_correction").clamped(corrected_roll)
    return rules.table("vehicle_correction").clamped(corrected_roll, armour)


def _target_class(named: TargetClass | str) -> TargetClass:
    for kind in TargetClass:
        if named == kind or (isinstance(named, str) and named.upper() == kind.name):
            return kind
    names = ", ".join(kind.name.lower() for kind in TargetClass)
    raise ConfigError(f"unknown target class {named!r}; known: {names}")


def _check(name: str, value: int, low: int, high: int) -> None:
    if value not in range(low, high + 1):
        raise ConfigError(f"{name} must be in {low}..{high}, got {value}")
