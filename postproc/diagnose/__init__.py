"""Where recordings and the machine's model differ, what physics was left out, and by how much the
fit improves with it."""
