"""For every sentence that stops a program: a program that provokes it, and the same with its advice
followed."""
