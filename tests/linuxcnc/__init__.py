"""LinuxCNC's interpreter as a witness for gcomp's own (README.md)."""
