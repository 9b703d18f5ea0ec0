"""What ``benches/peers/run.py`` is made of."""
