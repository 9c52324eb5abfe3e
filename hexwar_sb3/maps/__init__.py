"""Maps and scenarios: geometry, files, a generator, three built-in maps, and what kernels read of them."""
