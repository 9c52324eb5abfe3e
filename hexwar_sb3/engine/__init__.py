"""The engine: records, kernels, orders, one game and a batch of games, views, replays."""
