X=AC(2)
