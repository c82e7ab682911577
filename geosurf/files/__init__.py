"""Files that geosurf writes: whole or not at all, one (`atomic`) or many (`folders`), under a claim
(`locks`). See docs/decisions/0018-files-old-or-new.md.
"""
