"""Surfaces that break engines, judged with arithmetic that shares nothing with the engine.

``make stress``, or ``python -m benchmarks.stress --cases 2000 --seed 7``.
"""
