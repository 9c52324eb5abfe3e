"""Networks, mixers and policy classes for Stable-Baselines3 (Fig. 4, Fig. 5)."""

from lazy_loader import attach_stub

if __name__ == "policies":  # the folder, found from the root; the package is hexwar_sb3.policies
    raise ImportError("import hexwar_sb3.policies, not policies")

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)  # each name is imported when it is first used
