"""Long, Yuan, Xu, Du (2014): positioning of a lathe axis by fuzzy control on a variable universe of discourse."""
