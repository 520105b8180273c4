%
G0 Z9
