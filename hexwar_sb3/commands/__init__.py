"""The sub-commands of `hexwar`, one module each."""
