"""TEXT: program text <-> columns of numbers. Knows no physics and opens nothing."""
