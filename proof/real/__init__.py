"""Proof on recordings of real machines: what their authors know is taken out of the model, and
gcomp has to find it again."""
