"""Tasks (III-A): task sets, what a shot is worth, features, and phi, eq. (2)."""
