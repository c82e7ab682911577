"""Files that geosurf writes: whole or unchanged, one (`atomic`) or many (`folders`), under a claim
(`locks`).
"""
