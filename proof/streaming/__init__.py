"""Streaming, judged by the step pulses of a real GRBL 1.1h image: `python -m proof.streaming`."""
