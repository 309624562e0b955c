"""How well commands are understood: recordings with known texts, scores and pictures.

`recognize` hears the recordings with one of the `engines`, in `noise` if asked; `stretches` assigns
what was heard; `scores`, `curves` and `comparison` count; `tables`, `plots` and `page` show it.
"""
