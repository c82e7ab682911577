"""Files that geosurf writes: whole or unchanged, one (`atomic`) or many (`folders`), under a claim
(`locks`). See docs/decisions/0018-files-old-or-new.md.
"""
