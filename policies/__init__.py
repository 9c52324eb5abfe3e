"""Networks, mixers and policy classes for Stable-Baselines3 (Fig. 4, Fig. 5)."""

if __name__ == "policies":  # the folder, found from the root; the package is hexwar_sb3.policies
    raise ImportError("import hexwar_sb3.policies, not policies")
